// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/aravis/stream_guard.h"

#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <dirent.h>
#include <netinet/in.h>
#include <optional>
#include <string>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace cliquevo::drivers {

namespace {

// Where things stand in a datagram as the filter sees it: behind the UDP header, GigE Vision's stream protocol 2.x.
constexpr std::uint32_t kUdpHeader = 8;
constexpr std::uint32_t kIpAndUdpHeaders = 28;
constexpr std::uint32_t kIpSource = static_cast<std::uint32_t>(SKF_NET_OFF) + 12;
constexpr std::uint32_t kInfos = kUdpHeader + 4;  // flag of 64-bit frame numbers, kind, packet number (24 bits)
constexpr std::uint32_t kExtendedFlag = 0x80;
constexpr std::uint32_t kKindMask = 0x7f;
enum Kind : std::uint32_t { kLeader = 1, kTrailer = 2, kPayload = 3 };
constexpr std::uint32_t kImage = 1;  // payload type of a leader, without the flag for appended chunks
constexpr std::uint32_t kPayloadTypeMask = 0x3fff;

// The two headers there are.
struct Header {
  std::uint32_t size;
  std::uint32_t packet_number;  // a word; its upper byte is masked away where it is none of it
  std::uint32_t packet_number_mask;
};
constexpr Header kStandard{8, kInfos, 0x00ffffff};
constexpr Header kExtended{20, kUdpHeader + 16, 0xffffffff};
constexpr std::uint32_t kLeaderBytes = 36;
constexpr std::uint32_t kTrailerBytes = 4;

// Instructions whose jumps go to one end or to the next instruction, so that none is counted by hand.
class Program {
 public:
  void load_word(std::uint32_t at) { add(BPF_LD | BPF_W | BPF_ABS, at); }
  void load_half(std::uint32_t at) { add(BPF_LD | BPF_H | BPF_ABS, at); }
  void load_byte(std::uint32_t at) { add(BPF_LD | BPF_B | BPF_ABS, at); }
  void load_length() { add(BPF_LD | BPF_W | BPF_LEN, 0); }
  void keep_bits(std::uint32_t mask) { add(BPF_ALU | BPF_AND | BPF_K, mask); }
  void drop_unless_equal(std::uint32_t value) { branch(BPF_JEQ, value, false); }
  void drop_unless_at_least(std::uint32_t value) { branch(BPF_JGE, value, false); }
  void drop_if_above(std::uint32_t value) { branch(BPF_JGT, value, true); }
  void accept() { add(BPF_RET | BPF_K, 0xffffffff); }
  void drop() { add(BPF_RET | BPF_K, 0); }
  // Runs `then` when the loaded value has these bits (or equals), and goes on behind it otherwise.
  template <typename Body>
  void when_bits(std::uint32_t bits, const Body& then) {
    when(BPF_JSET, bits, then);
  }
  template <typename Body>
  void when_equal(std::uint32_t value, const Body& then) {
    when(BPF_JEQ, value, then);
  }
  std::vector<sock_filter> take() { return std::move(code_); }

 private:
  void add(int code, std::uint32_t k) { code_.push_back({static_cast<std::uint16_t>(code), 0, 0, k}); }
  void branch(int condition, std::uint32_t k, bool drop_if_true) {
    const std::uint8_t over = 1;  // the drop that follows
    code_.push_back({static_cast<std::uint16_t>(BPF_JMP | condition | BPF_K), drop_if_true ? std::uint8_t{0} : over,
                     drop_if_true ? over : std::uint8_t{0}, k});
    drop();
  }
  template <typename Body>
  void when(int condition, std::uint32_t k, const Body& then) {
    const std::size_t at = code_.size();
    code_.push_back({static_cast<std::uint16_t>(BPF_JMP | condition | BPF_K), 0, 0, k});
    then();
    code_[at].jf = static_cast<std::uint8_t>(code_.size() - at - 1);
  }
  std::vector<sock_filter> code_;
};

void leader(Program& p, const StreamShape& shape, const Header& header) {
  const std::uint32_t body = kUdpHeader + header.size;
  p.load_length();
  p.drop_unless_at_least(body + kLeaderBytes);
  p.load_word(header.packet_number);
  p.keep_bits(header.packet_number_mask);
  p.drop_unless_equal(0);
  p.load_half(body + 2);
  p.keep_bits(kPayloadTypeMask);
  p.drop_unless_equal(kImage);
  p.load_word(body + 16);
  p.drop_unless_equal(shape.width);
  p.load_word(body + 20);
  p.drop_unless_equal(shape.height);
  p.accept();
}

// Packets of one kind, numbered from 1 to `most`.
void numbered(Program& p, const Header& header, std::uint32_t least_bytes, std::uint32_t most) {
  p.load_length();
  p.drop_unless_at_least(kUdpHeader + header.size + least_bytes);
  p.load_word(header.packet_number);
  p.keep_bits(header.packet_number_mask);
  p.drop_unless_at_least(1);
  p.drop_if_above(most);
  p.accept();
}

void packets(Program& p, const StreamShape& shape, const Header& header) {
  const std::size_t block = shape.packet_bytes - kIpAndUdpHeaders - header.size;
  const auto blocks = static_cast<std::uint32_t>((shape.payload_bytes + block - 1) / block);
  const auto kind = [&p] {
    p.load_byte(kInfos);
    p.keep_bits(kKindMask);
  };
  kind();
  p.when_equal(kPayload, [&] { numbered(p, header, 1, blocks); });
  p.when_equal(kTrailer, [&] { numbered(p, header, kTrailerBytes, blocks + 1); });
  p.drop_unless_equal(kLeader);
  leader(p, shape, header);
}

std::optional<int> find_socket(std::uint16_t port) {
  DIR* folder = ::opendir("/proc/self/fd");
  if (folder == nullptr) return std::nullopt;
  std::optional<int> found;
  while (const dirent* entry = ::readdir(folder)) {
    const int descriptor = std::atoi(entry->d_name);
    sockaddr_in address = {};
    socklen_t size = sizeof address;
    int type = 0;
    socklen_t type_size = sizeof type;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) continue;
    if (address.sin_family != AF_INET || ntohs(address.sin_port) != port) continue;
    if (::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &type_size) == 0 && type == SOCK_DGRAM) found = descriptor;
  }
  ::closedir(folder);
  return found;
}

}  // namespace

std::vector<sock_filter> stream_filter(const StreamShape& shape) {
  Program p;
  if (shape.packet_bytes <= kIpAndUdpHeaders + kExtended.size) {
    p.drop();
    return p.take();
  }
  p.load_word(kIpSource);
  p.drop_unless_equal(shape.camera_address);
  p.load_length();
  p.drop_unless_at_least(kUdpHeader + kStandard.size);
  p.load_byte(kInfos);
  p.when_bits(kExtendedFlag, [&] { packets(p, shape, kExtended); });
  packets(p, shape, kStandard);
  return p.take();
}

Result<void> guard_stream(std::uint16_t port, const std::vector<sock_filter>& filter) {
  const std::optional<int> descriptor = find_socket(port);
  if (!descriptor) return Error{"cannot guard the stream", "port " + std::to_string(port), "its socket is not found"};
  std::vector<sock_filter> code = filter;
  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  if (::setsockopt(*descriptor, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) != 0) {
    return Error{"cannot guard the stream", "port " + std::to_string(port), std::strerror(errno)};
  }
  // Nothing has a buffer yet: what came before the filter is read and dropped.
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    int waiting = 0;
    if (::ioctl(*descriptor, FIONREAD, &waiting) != 0 || waiting == 0) break;
    ::usleep(1000);
  }
  return {};
}

}  // namespace cliquevo::drivers
