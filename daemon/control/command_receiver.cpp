// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/control/command_receiver.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "core/base/caught.h"
#include "core/base/time.h"
#include "core/rt/thread.h"
#include "daemon/lcm/lcm_url.h"
#include "daemon/lcm/local_addresses.h"

namespace cliquevo::daemon {

namespace {

constexpr int kPollMs = 100;           // how soon it notices that it should end
constexpr std::size_t kLongest = 512;  // of a datagram; a command takes some 60 bytes
constexpr int kMostASecond = 10;       // commands that are done
constexpr int kAtOnce = 256;           // datagrams read before it looks whether it should end

// A socket that gets the group's datagrams and nothing that is sent to the machine itself.
Result<int> join(const MulticastUrl& to, const std::string& url) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const auto bad = [&](const char* what) {
    Error error{std::string("cannot listen for commands: ") + what, url, std::strerror(errno)};
    if (fd >= 0) ::close(fd);
    return error;
  };
  if (fd < 0) return bad("no socket");
  const int on = 1;
  const int off = 0;
  // Other programs listen to the same group.
  if (::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0) return bad("the port cannot be shared");
  static_cast<void>(::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr = to.group;
  address.sin_port = htons(to.port);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return bad("no address");
  ip_mreq membership{};
  membership.imr_multiaddr = to.group;
  if (::setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) return bad("no group");
  return fd;
}

}  // namespace

struct CommandReceiver::Impl {
  Impl(int fd_, const MulticastUrl& url, std::string channel_, CommandHandler handler_, Incidents& incidents_)
      : fd(fd_),
        group(url.group),
        local_only(url.ttl == 0),
        channel(std::move(channel_)),
        handler(std::move(handler_)),
        incidents(incidents_) {}
  ~Impl() {
    stop = true;
    thread.join();
    ::close(fd);
  }

  void listen() {
    while (!stop) {
      pollfd readable{fd, POLLIN, 0};
      if (::poll(&readable, 1, kPollMs) <= 0) continue;
      for (int i = 0; i < kAtOnce && receive(); ++i) {
      }
    }
  }

  // false: nothing is there.
  bool receive() {
    std::array<std::uint8_t, kLongest> buffer{};
    sockaddr_in from{};
    socklen_t from_size = sizeof from;
    const ssize_t got = ::recvfrom(fd, buffer.data(), buffer.size(), MSG_TRUNC | MSG_DONTWAIT,
                                   reinterpret_cast<sockaddr*>(&from), &from_size);
    if (got < 0) return false;
    if (static_cast<std::size_t>(got) > buffer.size()) return true;  // pictures and the like
    std::int8_t number = 0;
    const Packet packet = parse_command_packet({buffer.data(), static_cast<std::size_t>(got)}, channel, number);
    if (packet == Packet::foreign) return true;
    if (local_only && !is_local(from.sin_addr)) {
      incidents.add("commands from another machine were ignored: lcm.url has ttl=0");
    } else if (packet == Packet::damaged) {
      incidents.add("damaged packets on the command channel were left alone");
    } else {
      carry_out(number);
    }
    return true;
  }

  // Where lo is the only interface, the machine's own packets bear no address. From outside the kernel takes none such,
  // but to 224.0.0.x.
  bool is_local(in_addr from) {
    const bool none_from_outside = ntohl(group.s_addr) >> 8U != 0xE00000U;
    return (from.s_addr == INADDR_ANY && none_from_outside) || local.contains(from);
  }

  void carry_out(std::int8_t number) {
    const auto command = command_of_number(number);
    if (!command) return incidents.add("commands that are not known were left alone");
    const std::int64_t now_ns = monotonic_ns();
    if (now_ns - second_ns >= 1'000'000'000) {
      second_ns = now_ns;
      this_second = 0;
    }
    if (++this_second > kMostASecond) return incidents.add("commands beyond 10 a second were left alone");
    const auto done = guarded("vo-command", [&] { return handler(*command); });
    if (!done) incidents.add(done.error().line());
  }

  int fd;
  in_addr group;
  bool local_only;
  std::string channel;
  CommandHandler handler;
  Incidents& incidents;
  LocalAddresses local;
  std::int64_t second_ns = 0;
  int this_second = 0;
  std::atomic<bool> stop{false};
  rt::Thread thread;
};

Result<CommandReceiver> CommandReceiver::start(const std::string& url, const std::string& channel,
                                               CommandHandler handler, Incidents& incidents) {
  const auto to = parse_multicast_url(url);
  if (!to) return to.error();
  const auto fd = join(*to, url);
  if (!fd) return fd.error();
  auto impl = std::make_unique<Impl>(*fd, *to, channel, std::move(handler), incidents);
  auto thread = rt::Thread::start({.name = "vo-command"}, [self = impl.get()] { self->listen(); });
  if (!thread) return thread.error();
  impl->thread = std::move(*thread);
  return CommandReceiver(std::move(impl));
}

CommandReceiver::CommandReceiver(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CommandReceiver::CommandReceiver(CommandReceiver&&) noexcept = default;
CommandReceiver::~CommandReceiver() = default;

}  // namespace cliquevo::daemon
