// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mavlink_wire.h"

#include <algorithm>
#include <bit>
#include <type_traits>

namespace cliquevo::tools::mavlink {

namespace {

constexpr std::uint8_t kMagic1 = 0xfe;
constexpr std::uint8_t kMagic2 = 0xfd;
constexpr std::uint8_t kSigned = 0x01;  // a signature of 13 bytes follows
constexpr std::uint32_t kTimeSyncId = 111;

constexpr std::uint16_t crc(std::uint16_t sum, std::uint8_t byte) {  // X.25
  auto t = static_cast<std::uint8_t>(byte ^ (sum & 0xffU));
  t = static_cast<std::uint8_t>(t ^ (t << 4U));
  return static_cast<std::uint16_t>((sum >> 8U) ^ (t << 8U) ^ (t << 3U) ^ (t >> 4U));
}

struct Field {
  std::string_view type;
  std::string_view name;
  std::uint8_t array = 0;
};

// What seeds a message's checksum: its name and its fields in the order of the wire, extensions left out.
template <std::size_t N>
constexpr std::uint8_t crc_extra(std::string_view name, const Field (&fields)[N]) {
  std::uint16_t sum = 0xffff;
  const auto add = [&](std::string_view text) {
    for (const char c : text) sum = crc(sum, static_cast<std::uint8_t>(c));
    sum = crc(sum, ' ');
  };
  add(name);
  for (const Field& f : fields) {
    add(f.type);
    add(f.name);
    if (f.array > 0) sum = crc(sum, f.array);
  }
  return static_cast<std::uint8_t>((sum & 0xffU) ^ (sum >> 8U));
}

constexpr std::uint8_t kHeartbeatExtra = crc_extra("HEARTBEAT", {{"uint32_t", "custom_mode"},
                                                                 {"uint8_t", "type"},
                                                                 {"uint8_t", "autopilot"},
                                                                 {"uint8_t", "base_mode"},
                                                                 {"uint8_t", "system_status"},
                                                                 {"uint8_t", "mavlink_version"}});
constexpr std::uint8_t kVisionExtra = crc_extra("VISION_POSITION_ESTIMATE", {{"uint64_t", "usec"},
                                                                             {"float", "x"},
                                                                             {"float", "y"},
                                                                             {"float", "z"},
                                                                             {"float", "roll"},
                                                                             {"float", "pitch"},
                                                                             {"float", "yaw"}});
constexpr std::uint8_t kTimeSyncExtra = crc_extra("TIMESYNC", {{"int64_t", "tc1"}, {"int64_t", "ts1"}});
constexpr std::uint8_t kOdometryExtra = crc_extra("ODOMETRY", {{"uint64_t", "time_usec"},
                                                               {"float", "x"},
                                                               {"float", "y"},
                                                               {"float", "z"},
                                                               {"float", "q", 4},
                                                               {"float", "vx"},
                                                               {"float", "vy"},
                                                               {"float", "vz"},
                                                               {"float", "rollspeed"},
                                                               {"float", "pitchspeed"},
                                                               {"float", "yawspeed"},
                                                               {"float", "pose_covariance", 21},
                                                               {"float", "velocity_covariance", 21},
                                                               {"uint8_t", "frame_id"},
                                                               {"uint8_t", "child_frame_id"}});
// As the message definitions' own generator has them.
static_assert(kHeartbeatExtra == 50 && kVisionExtra == 158 && kTimeSyncExtra == 34 && kOdometryExtra == 91);

class Payload {
 public:
  template <typename T>
  Payload& put(T value) {
    if constexpr (std::is_same_v<T, float>) {
      return put(std::bit_cast<std::uint32_t>(value));
    } else {
      const auto bits = static_cast<std::make_unsigned_t<T>>(value);
      for (std::size_t i = 0; i < sizeof(T); ++i) {
        bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(bits) >> (8 * i)));
      }
      return *this;
    }
  }
  template <std::size_t N>
  Payload& put(const std::array<float, N>& values) {
    for (const float value : values) put(value);
    return *this;
  }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

std::int64_t number_at(std::span<const std::uint8_t> payload, std::size_t at) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    if (at + i < payload.size()) bits |= std::uint64_t{payload[at + i]} << (8 * i);  // cut zeros
  }
  return static_cast<std::int64_t>(bits);
}

}  // namespace

std::vector<std::uint8_t> Sender::frame(std::uint32_t id, std::uint8_t extra, std::vector<std::uint8_t> payload) {
  while (payload.size() > 1 && payload.back() == 0) payload.pop_back();  // MAVLink 2 cuts zeros at the end
  std::vector<std::uint8_t> out{kMagic2,
                                static_cast<std::uint8_t>(payload.size()),
                                0,
                                0,
                                sequence_++,
                                system_,
                                component_,
                                static_cast<std::uint8_t>(id),
                                static_cast<std::uint8_t>(id >> 8U),
                                static_cast<std::uint8_t>(id >> 16U)};
  out.insert(out.end(), payload.begin(), payload.end());
  std::uint16_t sum = 0xffff;
  for (std::size_t i = 1; i < out.size(); ++i) sum = crc(sum, out[i]);
  sum = crc(sum, extra);
  out.push_back(static_cast<std::uint8_t>(sum & 0xffU));
  out.push_back(static_cast<std::uint8_t>(sum >> 8U));
  return out;
}

std::vector<std::uint8_t> Sender::heartbeat(bool active) {
  constexpr std::uint8_t kOnboardController = 18;
  constexpr std::uint8_t kNoAutopilot = 8;
  constexpr std::uint8_t kStandby = 3;
  constexpr std::uint8_t kActive = 4;
  constexpr std::uint8_t kVersion = 3;
  Payload p;
  p.put(std::uint32_t{0}).put(kOnboardController).put(kNoAutopilot).put(std::uint8_t{0});
  p.put(active ? kActive : kStandby).put(kVersion);
  return frame(0, kHeartbeatExtra, p.take());
}

std::vector<std::uint8_t> Sender::odometry(const Odometry& m) {
  Payload p;
  p.put(m.time_usec).put(m.position).put(m.q).put(m.velocity).put(m.rates);
  p.put(m.pose_covariance).put(m.velocity_covariance).put(m.frame_id).put(m.child_frame_id);
  p.put(m.reset_counter).put(m.estimator_type).put(m.quality);
  return frame(331, kOdometryExtra, p.take());
}

std::vector<std::uint8_t> Sender::vision_position(const VisionPosition& m) {
  Payload p;
  p.put(m.usec).put(m.position).put(m.roll_pitch_yaw).put(m.covariance).put(m.reset_counter);
  return frame(102, kVisionExtra, p.take());
}

std::vector<std::uint8_t> Sender::timesync(const TimeSync& m) {
  Payload p;
  p.put(m.tc1).put(m.ts1);
  return frame(kTimeSyncId, kTimeSyncExtra, p.take());
}

void Receiver::add(std::span<const std::uint8_t> bytes, const std::function<void(const TimeSync&)>& on_timesync) {
  constexpr std::size_t kMostPending = 4096;
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  std::size_t at = 0;
  while (at < pending_.size()) {
    const std::uint8_t magic = pending_[at];
    if (magic != kMagic1 && magic != kMagic2) {
      ++at;
      continue;
    }
    const std::span<const std::uint8_t> rest = std::span(pending_).subspan(at);
    const std::size_t head = magic == kMagic2 ? 10 : 6;
    if (rest.size() < head) break;
    const std::size_t signature = magic == kMagic2 && (rest[2] & kSigned) != 0 ? 13 : 0;
    const std::size_t whole = head + rest[1] + 2;
    if (rest.size() < whole + signature) break;
    const std::uint32_t id = magic == kMagic2 ? rest[7] | static_cast<std::uint32_t>(rest[8]) << 8U |
                                                    static_cast<std::uint32_t>(rest[9]) << 16U
                                              : rest[5];
    // Checksums of other messages are not known: what looks like one is passed byte by byte.
    std::uint16_t sum = 0xffff;
    for (std::size_t i = 1; i < whole - 2; ++i) sum = crc(sum, rest[i]);
    sum = crc(sum, kTimeSyncExtra);
    const bool right = id == kTimeSyncId && rest[whole - 2] == (sum & 0xffU) && rest[whole - 1] == sum >> 8U;
    if (right) {
      const auto payload = rest.subspan(head, rest[1]);
      on_timesync({number_at(payload, 0), number_at(payload, 8)});
    }
    at += right ? whole + signature : 1;
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(at));
  if (pending_.size() > kMostPending) pending_.clear();
}

}  // namespace cliquevo::tools::mavlink
