// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/lcm_url.h"

#include <arpa/inet.h>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "daemon/lcm/tcpq_client.h"

namespace cliquevo::daemon {

namespace {

constexpr const char* kServerRemedy = "write it as tcpq://HOST:PORT";
constexpr const char* kFormRemedy = "write it as udpm://239.255.76.67:7667?ttl=0";

Error bad(const std::string& what, const std::string& url, const std::string& remedy = kFormRemedy) {
  return {what, url, remedy};
}

std::optional<long> number(const std::string& text) {
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct Parts {
  std::string provider;
  std::string network;  // what stands between :// and ?
  std::vector<std::pair<std::string, std::string>> options;
};

std::optional<Parts> split(const std::string& url) {
  const std::size_t scheme_end = url.find("://");
  if (scheme_end == std::string::npos || scheme_end == 0) return std::nullopt;
  Parts parts;
  parts.provider = url.substr(0, scheme_end);
  const std::string rest = url.substr(scheme_end + 3);
  const std::size_t question = rest.find('?');
  parts.network = rest.substr(0, question);
  if (question == std::string::npos) return parts;
  std::string options = rest.substr(question + 1);
  while (!options.empty()) {
    const std::size_t end = options.find('&');
    const std::string one = options.substr(0, end);
    const std::size_t equal = one.find('=');
    if (equal == std::string::npos) return std::nullopt;
    parts.options.emplace_back(one.substr(0, equal), one.substr(equal + 1));
    options = end == std::string::npos ? std::string{} : options.substr(end + 1);
  }
  return parts;
}

class Socket {
 public:
  explicit Socket(int type) : fd_(::socket(AF_INET, type | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

Result<std::pair<std::string, std::uint16_t>> host_and_port(const Parts& parts, const std::string& url) {
  const std::size_t colon = parts.network.rfind(':');
  const auto port = colon == std::string::npos ? std::nullopt : number(parts.network.substr(colon + 1));
  if (!port || *port < 1 || *port > 65535) return bad("LCM URL without a port from 1 to 65535", url);
  return std::pair{parts.network.substr(0, colon), static_cast<std::uint16_t>(*port)};
}

Result<MulticastUrl> multicast_of(const Parts& parts, const std::string& url) {
  const auto address = host_and_port(parts, url);
  if (!address) return address.error();
  MulticastUrl out;
  out.port = address->second;
  if (::inet_pton(AF_INET, address->first.c_str(), &out.group) != 1 || !IN_MULTICAST(ntohl(out.group.s_addr))) {
    return bad("LCM URL without a multicast address (224.0.0.0 to 239.255.255.255)", url);
  }
  for (const auto& [key, text] : parts.options) {
    const auto value = number(text);
    if (key != "ttl" && key != "recv_buf_size") return bad("unknown option '" + key + "' in the LCM URL", url);
    if (!value || *value < 0 || (key == "ttl" && *value > 255)) {
      return bad("bad value of '" + key + "' in the LCM URL", url);
    }
    if (key == "ttl") out.ttl = static_cast<int>(*value);
  }
  return out;
}

Result<void> check_multicast(const Parts& parts, const std::string& url) {
  const auto address = multicast_of(parts, url);
  if (!address) return address.error();
  // Connecting a datagram socket sends nothing; it only looks up the route.
  const Socket probe(SOCK_DGRAM);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(address->port);
  to.sin_addr = address->group;
  if (probe.fd() < 0 || ::connect(probe.fd(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    return bad(std::string("no route for LCM messages (") + std::strerror(errno) + ")", url,
               "ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo");
  }
  return {};
}

Result<void> check_server(const std::string& url) {
  const auto client = TcpqClient::open(url);
  if (!client) return client.error();
  return {};
}

Result<void> check_file(const Parts& parts, const std::string& url) {
  if (parts.network.empty()) return bad("LCM URL without a file name", url, "write it as file:///path/run.log?mode=w");
  bool writes = false;
  for (const auto& [key, value] : parts.options) writes = writes || (key == "mode" && (value == "w" || value == "a"));
  if (!writes) {
    return bad("LCM URL of a log that is not open for writing", url, "write it as file:///path/run.log?mode=w");
  }
  const int fd = ::open(parts.network.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0640);
  if (fd < 0)
    return bad(std::string("cannot write the LCM log (") + std::strerror(errno) + ")", url, "name another file");
  ::close(fd);
  return {};
}

}  // namespace

Result<MulticastUrl> parse_multicast_url(const std::string& url) {
  const auto parts = split(url);
  if (!parts || parts->provider != "udpm") return bad("no LCM URL of a multicast group", url);
  return multicast_of(*parts, url);
}

Result<ServerUrl> parse_server_url(const std::string& url) {
  auto parts = split(url);
  if (!parts || parts->provider != "tcpq") return bad("no LCM URL of a server", url, kServerRemedy);
  // LCM's own default is localhost:7700.
  if (parts->network.empty()) parts->network = "localhost";
  if (parts->network.find(':') == std::string::npos) parts->network += ":7700";
  const auto address = host_and_port(*parts, url);
  if (!address) return address.error();
  return ServerUrl{address->first, address->second};
}

Result<void> check_lcm_url(const std::string& url) {
  const auto parts = split(url);
  if (!parts) return bad("malformed LCM URL", url.empty() ? "(empty)" : url);
  if (parts->provider == "udpm") return check_multicast(*parts, url);
  if (parts->provider == "tcpq") return check_server(url);
  if (parts->provider == "file") return check_file(*parts, url);
  if (parts->provider == "memq") return {};
  return bad("unknown LCM provider '" + parts->provider + "'", url);
}

}  // namespace cliquevo::daemon
