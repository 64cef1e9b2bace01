// SPDX-License-Identifier: BSD-3-Clause
// A UVC camera answered from user space: USB/IP over a socket pair that the kernel's vhci_hcd takes for the wire, so
// that the stock uvcvideo driver binds to it. It sends frames made up from
// their number, YUYV; two of them as if one trigger ran both.
//   uvc_camera PORT WIDTH HEIGHT FPS SERIAL SEED
#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <deque>
#include <fcntl.h>
#include <poll.h>
#include <string>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

#include "tests/vm/made_up_yuyv.h"

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kSubmit = 1;
constexpr std::uint32_t kUnlink = 2;
constexpr std::uint32_t kSubmitted = 3;
constexpr std::uint32_t kUnlinked = 4;
constexpr std::size_t kMostPayload = 16384;
constexpr int kHighSpeed = 3;

// USB/IP's header, in the order of the wire (all big-endian); what the five numbers mean depends on the command.
struct Header {
  std::uint32_t command, sequence, device, direction, endpoint;
  std::uint32_t a, b, c, d, e;
  std::array<std::uint8_t, 8> setup;
};
static_assert(sizeof(Header) == 48);

std::int64_t now_ns() {
  timespec now = {};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void put(Bytes& out, std::initializer_list<unsigned> bytes) {
  for (const unsigned byte : bytes) out.push_back(static_cast<std::uint8_t>(byte));
}
void put16(Bytes& out, unsigned value) { put(out, {value & 255U, value >> 8U & 255U}); }
void put32(Bytes& out, std::uint32_t value) {
  put16(out, value & 0xffffU);
  put16(out, value >> 16U);
}

class Camera {
 public:
  Camera(unsigned width, unsigned height, double fps, std::string serial, unsigned seed)
      : width_(width),
        height_(height),
        interval_(static_cast<std::uint32_t>(1e7 / fps)),
        serial_(std::move(serial)),
        seed_(seed),
        frame_(std::size_t{2} * width * height) {
    describe();
  }

  bool attach(int port) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return false;
    socket_ = ends[0];
    const std::string line = std::to_string(port) + " " + std::to_string(ends[1]) + " " +
                             std::to_string((1 << 16) | (port + 2)) + " " + std::to_string(kHighSpeed);
    const int attach = ::open("/sys/devices/platform/vhci_hcd.0/attach", O_WRONLY);
    const bool done = attach >= 0 && ::write(attach, line.data(), line.size()) == static_cast<ssize_t>(line.size());
    ::close(attach);
    ::close(ends[1]);
    return done;
  }

  // Until the kernel hangs up.
  void serve() {
    for (;;) {
      pollfd wait = {socket_, POLLIN, 0};
      const int ready = ::poll(&wait, 1, patience_ms());
      if (ready > 0) {
        if (!handle()) return;
      } else if (!asked_.empty() && sent_ == 0 && now_ns() - due_ns_ > period_ns() / 10) {
        due_ns_ = next_tick_ns();  // held up: a camera would not expose later for that
      } else if (!asked_.empty() && (sent_ > 0 || now_ns() >= due_ns_)) {
        if (!send_part()) return;
      }
    }
  }

 private:
  int patience_ms() const {
    if (asked_.empty()) return 1000;
    if (sent_ > 0) return 0;
    const std::int64_t left_ns = due_ns_ - now_ns();
    return left_ns > 0 ? static_cast<int>(left_ns / 1'000'000) + 1 : 0;
  }

  // Both cameras expose at the same moments, as if one trigger ran them.
  std::int64_t period_ns() const { return std::int64_t{interval_} * 100; }
  std::int64_t next_tick_ns() const { return (now_ns() / period_ns() + 1) * period_ns(); }

  bool read_all(void* data, std::size_t size) {
    auto* to = static_cast<std::uint8_t*>(data);
    while (size > 0) {
      const ssize_t got = ::read(socket_, to, size);
      if (got <= 0) return false;
      to += got;
      size -= static_cast<std::size_t>(got);
    }
    return true;
  }
  bool write_all(const Bytes& bytes) {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t sent = ::send(socket_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (sent <= 0) return false;
      at += static_cast<std::size_t>(sent);
    }
    return true;
  }

  // Completes a request: with data where it asked for some, or with an error.
  bool complete(const Header& request, int status, const std::uint8_t* data, std::size_t size, bool carries_data) {
    Header reply = {};
    reply.command = htonl(kSubmitted);
    reply.sequence = htonl(request.sequence);
    reply.a = htonl(static_cast<std::uint32_t>(status));
    reply.b = htonl(static_cast<std::uint32_t>(size));
    Bytes bytes(sizeof reply);
    std::memcpy(bytes.data(), &reply, sizeof reply);
    if (carries_data) bytes.insert(bytes.end(), data, data + size);
    return write_all(bytes);
  }
  bool answer(const Header& request, const Bytes& data) {
    const std::size_t asked = request.setup[6] | static_cast<std::size_t>(request.setup[7]) << 8U;
    return complete(request, 0, data.data(), std::min(asked, data.size()), true);
  }
  bool stall(const Header& request) { return complete(request, -EPIPE, nullptr, 0, false); }

  bool handle() {
    Header request = {};
    if (!read_all(&request, sizeof request)) return false;
    for (std::uint32_t* number :
         {&request.command, &request.sequence, &request.direction, &request.endpoint, &request.a, &request.b}) {
      *number = ntohl(*number);
    }
    if (request.command == kUnlink) return unlink(request);
    if (request.command != kSubmit) return false;
    const std::size_t length = request.b;
    Bytes received(request.direction == 0 ? length : 0);
    if (!read_all(received.data(), received.size())) return false;
    if (request.endpoint == 0) return control(request, length);
    if (request.endpoint != 1 || request.direction == 0) return stall(request);
    if (asked_.empty() && now_ns() - due_ns_ > 1'000'000'000) {  // streaming begins
      due_ns_ = next_tick_ns();
      sent_ = 0;
    }
    asked_.push_back(request);
    return true;
  }

  bool unlink(const Header& request) {
    const auto found =
        std::find_if(asked_.begin(), asked_.end(), [&](const Header& h) { return h.sequence == request.a; });
    Header reply = {};
    reply.command = htonl(kUnlinked);
    reply.sequence = htonl(request.sequence);
    reply.a = htonl(found != asked_.end() ? static_cast<std::uint32_t>(-ECONNRESET) : 0U);
    if (found != asked_.end()) asked_.erase(found);
    sent_ = 0;
    Bytes bytes(sizeof reply);
    std::memcpy(bytes.data(), &reply, sizeof reply);
    return write_all(bytes);
  }

  bool control(const Header& request, std::size_t length) {
    const auto& s = request.setup;
    const unsigned type = s[0];
    const unsigned what = s[1];
    if (type == 0x80 && what == 6) return descriptor(request, s[3], s[2]);
    if (type == 0x80 && what == 0) return answer(request, {0, 0});  // status
    if (type == 0x81 && what == 10) return answer(request, {0});    // interface setting
    if (type == 0xa1 && s[4] == 1 && (s[3] == 1 || s[3] == 2)) {    // probe and commit of the stream
      if (what == 0x85) return answer(request, {34, 0});            // their length
      if (what == 0x86) return answer(request, {3});                // can be read and set
      return answer(request, probe());
    }
    if (type == 0x21 || type <= 2) return complete(request, 0, nullptr, length, false);
    return stall(request);
  }

  bool descriptor(const Header& request, unsigned kind, unsigned index) {
    if (kind == 1) {
      return answer(request, {18, 1, 0, 2, 0xef, 2, 1, 64, 0x6b, 0x1d, 0x02, 0x01, 0, 1, 1, 2, 3, 1});
    }
    if (kind == 2) return answer(request, configuration_);
    if (kind != 3) return stall(request);
    if (index == 0) return answer(request, {4, 3, 9, 4});
    const std::string text = index == 1 ? "cliquevo" : index == 2 ? "simulated camera" : serial_;
    Bytes out{static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
    for (const char c : text) put(out, {static_cast<unsigned char>(c), 0});
    return answer(request, out);
  }

  Bytes probe() const {
    Bytes out;
    put(out, {1, 0, 1, 1});
    put32(out, interval_);
    out.resize(18);
    put32(out, static_cast<std::uint32_t>(frame_.size()));
    put32(out, kMostPayload);
    put32(out, 48'000'000);
    put(out, {3, 1, 1, 1});
    return out;
  }

  // Configuration, interface association, control interface (camera terminal to output), streaming interface with one
  // YUYV format of one size, and its bulk endpoint.
  void describe() {
    Bytes& c = configuration_;
    const auto bits = static_cast<std::uint32_t>(frame_.size() * 8 * (10'000'000 / interval_));
    put(c, {9, 2, 0, 0, 2, 1, 0, 0x80, 250});
    put(c, {8, 11, 0, 2, 0x0e, 3, 0, 0});
    put(c, {9, 4, 0, 0, 0, 0x0e, 1, 0, 2});
    put(c, {13, 0x24, 1, 0x10, 0x01, 13 + 17 + 9, 0});
    put32(c, 48'000'000);
    put(c, {1, 1});
    put(c, {17, 0x24, 2, 1, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0});
    put(c, {9, 0x24, 3, 2, 0x01, 0x01, 0, 1, 0});
    put(c, {9, 4, 1, 0, 1, 0x0e, 2, 0, 0});
    put(c, {14, 0x24, 1, 1, 14 + 27 + 30, 0, 0x81, 0, 2, 0, 0, 0, 1, 0});
    put(c, {27, 0x24, 4,    1, 1,    'Y',  'U',  'Y', '2', 0, 0, 0x10, 0, 0x80,
            0,  0,    0xaa, 0, 0x38, 0x9b, 0x71, 16,  1,   0, 0, 0,    0});
    put(c, {30, 0x24, 5, 1, 0});
    put16(c, width_);
    put16(c, height_);
    put32(c, bits);
    put32(c, bits);
    put32(c, static_cast<std::uint32_t>(frame_.size()));
    put32(c, interval_);
    put(c, {1});
    put32(c, interval_);
    put(c, {7, 5, 0x81, 2, 0, 2, 0});
    c[2] = static_cast<std::uint8_t>(c.size() & 255U);
    c[3] = static_cast<std::uint8_t>(c.size() >> 8U);
  }

  bool send_part() {
    if (sent_ == 0) {
      toggle_ ^= 1U;
      const auto number = static_cast<unsigned>(due_ns_ / period_ns());
      cliquevo::test::make_up_yuyv(number, seed_, width_, height_, frame_.data());
    }
    const std::size_t size = std::min(frame_.size() - sent_, kMostPayload - 2);
    const bool last = sent_ + size == frame_.size();
    Bytes payload{2, static_cast<std::uint8_t>(0x80U | toggle_ | (last ? 2U : 0U))};
    payload.insert(payload.end(), frame_.begin() + static_cast<std::ptrdiff_t>(sent_),
                   frame_.begin() + static_cast<std::ptrdiff_t>(sent_ + size));
    const Header request = asked_.front();
    asked_.pop_front();
    sent_ += size;
    if (last) {
      sent_ = 0;
      due_ns_ = next_tick_ns();
    }
    return complete(request, 0, payload.data(), std::min<std::size_t>(payload.size(), request.b), true);
  }

  unsigned width_;
  unsigned height_;
  std::uint32_t interval_;  // 100 ns
  std::string serial_;
  unsigned seed_;
  Bytes frame_;
  Bytes configuration_;
  int socket_ = -1;
  std::deque<Header> asked_;  // of the video endpoint, not yet completed
  std::size_t sent_ = 0;      // of the present frame
  unsigned toggle_ = 0;
  std::int64_t due_ns_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "usage: %s PORT WIDTH HEIGHT FPS SERIAL SEED\n", argv[0]);
    return 2;
  }
  Camera camera(static_cast<unsigned>(std::atoi(argv[2])), static_cast<unsigned>(std::atoi(argv[3])),
                std::atof(argv[4]), argv[5], static_cast<unsigned>(std::atoi(argv[6])));
  if (!camera.attach(std::atoi(argv[1]))) {
    std::perror("uvc_camera: cannot attach to vhci_hcd");
    return 1;
  }
  camera.serve();
  return 0;
}
