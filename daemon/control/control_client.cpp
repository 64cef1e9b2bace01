// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/control/control_client.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <sys/time.h>

namespace cliquevo::daemon {

namespace {

constexpr std::size_t kLongestReply = 1 << 16;

std::string remedy_for(int error) {
  if (error == EACCES) return "it is for its owner and group: join the group (usermod -aG cliquevo USER), or be root";
  if (error == ENOENT || error == ECONNREFUSED) return "start cliquevod, or name its socket with --socket";
  return std::strerror(error);
}

// "error what: where: what to do", as the daemon wrote it.
Error refusal(const std::string& line, const std::string& path) {
  const std::size_t first = line.find(": ");
  const std::size_t last = line.rfind(": ");
  if (first == std::string::npos || last == first) return {"the daemon refuses", path, line};
  return {line.substr(0, first), line.substr(first + 2, last - first - 2), line.substr(last + 2)};
}

}  // namespace

Result<sockaddr_un> control_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return Error{"no control socket", path, "name a path of 1 to 107 bytes"};
  }
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  return address;
}

Result<FileDescriptor> connect_control(const std::string& path) {
  const auto address = control_address(path);
  if (!address) return address.error();
  FileDescriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  timeval limit{};
  limit.tv_sec = 2;
  if (fd.get() >= 0) ::setsockopt(fd.get(), SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  const bool connected =
      fd.get() >= 0 && ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0;
  if (!connected) return Error{"cannot reach the daemon", path, remedy_for(errno)};
  return fd;
}

Result<std::string> ask_daemon(const std::string& path, const std::string& request, double timeout_s) {
  const auto fd = connect_control(path);
  if (!fd) return fd.error();
  timeval limit{};
  limit.tv_sec = static_cast<time_t>(timeout_s);
  limit.tv_usec = static_cast<suseconds_t>((timeout_s - static_cast<double>(limit.tv_sec)) * 1e6);
  ::setsockopt(fd->get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  const std::string line = request + "\n";
  const Error silent{"the daemon does not answer", path, "see its log: journalctl -u cliquevod"};
  if (::send(fd->get(), line.data(), line.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(line.size())) return silent;
  std::string reply;
  std::array<char, 4096> bytes{};
  while (reply.find('\n') == std::string::npos && reply.size() < kLongestReply) {
    const ssize_t got = ::recv(fd->get(), bytes.data(), bytes.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return silent;
    reply.append(bytes.data(), static_cast<std::size_t>(got));
  }
  reply = reply.substr(0, reply.find('\n'));
  if (reply.starts_with("error ")) return refusal(reply.substr(6), path);
  if (!reply.starts_with("ok")) return silent;
  return reply.substr(std::min<std::size_t>(3, reply.size()));
}

}  // namespace cliquevo::daemon
