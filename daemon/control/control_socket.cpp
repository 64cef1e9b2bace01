// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/control/control_socket.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <list>
#include <optional>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "core/base/caught.h"
#include "core/base/time.h"
#include "core/rt/thread.h"
#include "daemon/control/control_client.h"
#include "daemon/control/file_descriptor.h"

namespace cliquevo::daemon {

namespace {

constexpr std::size_t kMostPeers = 8;
constexpr std::int64_t kIdleNs = 5'000'000'000;  // a peer that sends or reads nothing for so long is disconnected
constexpr int kLookMs = 500;                     // how often for idle ones
constexpr std::size_t kReadSize = 256;           // a peer's replies to so much are sent before more is read
constexpr mode_t kMode = 0660;                   // owner and group

struct Peer {
  FileDescriptor fd;
  ControlSession session;
  std::string out;  // replies not sent yet
  bool closing = false;
  std::int64_t last_ns = 0;
};

// What is at the path may be a socket that nobody listens on any more.
Result<void> make_way(const std::string& path) {
  struct stat status = {};
  if (::lstat(path.c_str(), &status) != 0) return {};
  if (!S_ISSOCK(status.st_mode)) return Error{"no control socket", path, "it is another file: name a free path"};
  const auto address = control_address(path);
  if (!address) return address.error();
  const FileDescriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (::connect(probe.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0 ||
      errno != ECONNREFUSED) {
    return Error{"no control socket", path, "another cliquevod listens there: name a free path"};
  }
  ::unlink(path.c_str());
  return {};
}

Result<FileDescriptor> listen_at(const std::string& path) {
  const auto address = control_address(path);
  if (!address) return address.error();
  if (auto ok = make_way(path); !ok) return ok.error();
  FileDescriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  // Its rights are those of the socket itself, cut by the umask: never more than kMode, and all of it afterwards.
  const bool listening = fd.get() >= 0 && ::fchmod(fd.get(), kMode) == 0 &&
                         ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0 &&
                         ::chmod(path.c_str(), kMode) == 0 && ::listen(fd.get(), static_cast<int>(kMostPeers)) == 0;
  if (!listening) return Error{"no control socket", path, std::strerror(errno)};
  return fd;
}

}  // namespace

struct ControlSocket::Impl {
  Impl(FileDescriptor listener_, std::string path_, ControlHandlers handlers_)
      : listener(std::move(listener_)), path(std::move(path_)), handlers(std::move(handlers_)) {
    ::lstat(path.c_str(), &own);
  }
  ~Impl() {
    const std::uint64_t one = 1;
    if (::write(stop.get(), &one, sizeof one) != sizeof one) return;  // cannot be
    thread.join();
    struct stat now = {};
    const bool ours = ::lstat(path.c_str(), &now) == 0 && now.st_ino == own.st_ino && now.st_dev == own.st_dev;
    if (ours) ::unlink(path.c_str());
  }

  void serve() {
    std::vector<pollfd> watched;
    for (;;) {
      watched.clear();
      watched.push_back({stop.get(), POLLIN, 0});
      watched.push_back({listener.get(), static_cast<short>(peers.size() < kMostPeers ? POLLIN : 0), 0});
      for (const Peer& peer : peers) {
        watched.push_back({peer.fd.get(), static_cast<short>(peer.out.empty() ? POLLIN : POLLOUT), 0});
      }
      if (::poll(watched.data(), watched.size(), kLookMs) < 0 && errno != EINTR) return;
      if (watched[0].revents != 0) return;
      const bool somebody_new = (watched[1].revents & POLLIN) != 0;
      std::size_t i = 2;
      for (auto peer = peers.begin(); peer != peers.end(); ++i) {
        const bool stays = guarded("vo-control", [&] { return attend(*peer, watched[i].revents); }).ok();
        peer = stays ? std::next(peer) : peers.erase(peer);
      }
      if (somebody_new) welcome();
    }
  }

  void welcome() {
    FileDescriptor fd(::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (fd.get() < 0) {  // no descriptors left: not to be tried again at once
      ::poll(nullptr, 0, 100);
      return;
    }
    peers.push_back(Peer{std::move(fd), ControlSession(handlers), "", false, monotonic_ns()});
  }

  // An error: hang up.
  Result<void> attend(Peer& peer, short events) {
    const Error gone{"hung up", path, ""};
    if (events == 0) return monotonic_ns() - peer.last_ns > kIdleNs ? Result<void>(gone) : Result<void>();
    peer.last_ns = monotonic_ns();
    if (peer.out.empty()) {
      std::array<char, kReadSize> bytes{};
      const ssize_t got = ::recv(peer.fd.get(), bytes.data(), bytes.size(), 0);
      if (got < 0 && (errno == EAGAIN || errno == EINTR)) return {};
      if (got <= 0) return gone;
      peer.closing = !peer.session.take({bytes.data(), static_cast<std::size_t>(got)}, peer.out);
    }
    const ssize_t sent = ::send(peer.fd.get(), peer.out.data(), peer.out.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) return gone;
    if (sent > 0) peer.out.erase(0, static_cast<std::size_t>(sent));
    return peer.closing && peer.out.empty() ? Result<void>(gone) : Result<void>();
  }

  FileDescriptor listener;
  FileDescriptor stop{::eventfd(0, EFD_CLOEXEC)};
  std::string path;
  struct stat own = {};
  ControlHandlers handlers;
  std::list<Peer> peers;  // the thread's
  rt::Thread thread;
};

Result<ControlSocket> ControlSocket::open(const std::string& path, ControlHandlers handlers) {
  auto listener = listen_at(path);
  if (!listener) return listener.error();
  auto impl = std::make_unique<Impl>(std::move(*listener), path, std::move(handlers));
  if (impl->stop.get() < 0) return Error{"no control socket", path, std::strerror(errno)};
  auto thread = rt::Thread::start({.name = "vo-control"}, [self = impl.get()] { self->serve(); });
  if (!thread) return thread.error();
  impl->thread = std::move(*thread);
  return ControlSocket(std::move(impl));
}

ControlSocket::ControlSocket(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ControlSocket::ControlSocket(ControlSocket&&) noexcept = default;
ControlSocket::~ControlSocket() = default;

}  // namespace cliquevo::daemon
