// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mavlink_link.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <netdb.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

namespace cliquevo::tools {

namespace {

constexpr const char* kForms = "give udp:HOST:PORT or serial:DEVICE[:BAUD]";
constexpr std::size_t kMostPending = 2048;

struct Speed {
  int baud;
  speed_t code;
};
constexpr std::array kSpeeds{Speed{57600, B57600},     Speed{115200, B115200},   Speed{230400, B230400},
                             Speed{460800, B460800},   Speed{500000, B500000},   Speed{921600, B921600},
                             Speed{1000000, B1000000}, Speed{1500000, B1500000}, Speed{3000000, B3000000}};

Result<int> open_udp(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return Error{"wrong usage", "--to udp:" + text, kForms};
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  std::string host = text.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  if (const int bad = ::getaddrinfo(host.c_str(), text.substr(colon + 1).c_str(), &hints, &found); bad != 0) {
    return Error{"cannot find the host", "--to udp:" + text, ::gai_strerror(bad)};
  }
  const int descriptor = ::socket(found->ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, found->ai_protocol);
  const bool connected = descriptor >= 0 && ::connect(descriptor, found->ai_addr, found->ai_addrlen) == 0;
  const int why = errno;
  ::freeaddrinfo(found);
  if (connected) return descriptor;
  if (descriptor >= 0) ::close(descriptor);
  return Error{"cannot send there", "--to udp:" + text, std::strerror(why)};
}

Result<int> open_serial(const std::string& text) {
  std::string device = text;
  int baud = 921600;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string::npos) {
    const char* begin = text.data() + colon + 1;
    const auto [end, bad] = std::from_chars(begin, text.data() + text.size(), baud);
    if (bad != std::errc{} || end != text.data() + text.size()) {
      return Error{"wrong usage", "--to serial:" + text, kForms};
    }
    device = text.substr(0, colon);
  }
  const Speed* speed = nullptr;
  for (const Speed& s : kSpeeds) {
    if (s.baud == baud) speed = &s;
  }
  if (speed == nullptr) return Error{"serial line has no such speed", "--to serial:" + text, "give 57600 to 3000000"};
  const int descriptor = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return Error{"cannot open serial line", device, std::strerror(errno)};
  termios settings{};
  if (::tcgetattr(descriptor, &settings) != 0) {
    ::close(descriptor);
    return Error{"cannot open serial line", device, "it is none"};
  }
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS);
  ::cfsetispeed(&settings, speed->code);
  ::cfsetospeed(&settings, speed->code);
  if (::tcsetattr(descriptor, TCSANOW, &settings) != 0) {
    const int why = errno;
    ::close(descriptor);
    return Error{"cannot set serial line", device, std::strerror(why)};
  }
  return descriptor;
}

}  // namespace

Result<MavlinkLink> MavlinkLink::open(const std::string& to) {
  const bool serial = to.starts_with("serial:");
  if (!serial && !to.starts_with("udp:")) return Error{"wrong usage", "--to " + to, kForms};
  const Result<int> opened = serial ? open_serial(to.substr(7)) : open_udp(to.substr(4));
  if (!opened) return opened.error();
  return MavlinkLink(*opened, serial, to);
}

MavlinkLink::MavlinkLink(MavlinkLink&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      serial_(other.serial_),
      name_(std::move(other.name_)),
      pending_(std::move(other.pending_)) {}

MavlinkLink& MavlinkLink::operator=(MavlinkLink&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(serial_, other.serial_);
  std::swap(name_, other.name_);
  std::swap(pending_, other.pending_);
  return *this;
}

MavlinkLink::~MavlinkLink() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Error MavlinkLink::gone(int code) const {
  return {"MAVLink cannot be sent any more", name_, code == 0 ? "the line is closed" : std::strerror(code)};
}

Result<bool> MavlinkLink::send(std::span<const std::uint8_t> frame) {
  if (serial_) {
    if (pending_.size() + frame.size() > kMostPending) return false;
    pending_.insert(pending_.end(), frame.begin(), frame.end());
    if (auto ok = flush(); !ok) return ok.error();
    return true;
  }
  if (::send(descriptor_, frame.data(), frame.size(), MSG_NOSIGNAL) >= 0) return true;
  switch (errno) {
    case EAGAIN:
    case ENOBUFS:
    case EINTR:
    case ECONNREFUSED:  // nobody listens yet
    case ENETUNREACH:
    case EHOSTUNREACH:
    case ENETDOWN:
      return false;
    default:
      return gone(errno);
  }
}

Result<void> MavlinkLink::flush() {
  while (!pending_.empty()) {
    const ssize_t done = ::write(descriptor_, pending_.data(), pending_.size());
    if (done < 0 && (errno == EAGAIN || errno == EINTR)) return {};
    if (done <= 0) return gone(done < 0 ? errno : 0);
    pending_.erase(pending_.begin(), pending_.begin() + done);
  }
  return {};
}

Result<std::span<const std::uint8_t>> MavlinkLink::receive() {
  received_.resize(2048);
  const ssize_t got = ::read(descriptor_, received_.data(), received_.size());
  if (got < 0 && serial_ && errno != EAGAIN && errno != EINTR) return gone(errno);
  return std::span<const std::uint8_t>(received_).first(static_cast<std::size_t>(std::max<ssize_t>(0, got)));
}

}  // namespace cliquevo::tools
