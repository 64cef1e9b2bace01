// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/message_sizes.h"

namespace cliquevo::daemon {

namespace {

// Goes over a message's fields in their order; once it is beyond the end it stays there. Sizes are those of
// daemon/lcmtypes: a test encodes each type and expects the walk to end where the message does.
class Walk {
 public:
  explicit Walk(const MessageBytes& bytes) : bytes_(bytes) { skip(8); }  // the fingerprint

  Walk& skip(std::int64_t bytes) {
    if (bytes < 0 || bytes > static_cast<std::int64_t>(bytes_.size) - at_) {
      beyond_ = true;
    } else {
      at_ += bytes;
    }
    return *this;
  }
  // A count or size; 0 beyond the end.
  std::int64_t count() {
    const std::int64_t from = at_;
    if (beyond_ || skip(4).beyond_) return 0;
    const std::uint8_t* p = bytes_.data + from;
    const auto value = static_cast<std::int32_t>(std::uint32_t{p[0]} << 24U | std::uint32_t{p[1]} << 16U |
                                                 std::uint32_t{p[2]} << 8U | std::uint32_t{p[3]});
    if (value < 0) beyond_ = true;
    return value < 0 ? 0 : value;
  }
  Walk& text() {
    const std::int64_t size = count();  // with the zero at its end
    if (size < 1) beyond_ = true;
    return skip(size);
  }
  Walk& texts(std::int64_t n) {
    for (std::int64_t i = 0; i < n && !beyond_; ++i) text();
    return *this;
  }
  bool beyond() const { return beyond_; }
  bool at_end() const { return !beyond_ && at_ == static_cast<std::int64_t>(bytes_.size); }

 private:
  MessageBytes bytes_;
  std::int64_t at_ = 0;
  bool beyond_ = false;
};

}  // namespace

template <>
bool fits(const MessageBytes& bytes, const command_t&) {
  Walk walk(bytes);
  walk.skip(8 + 1).text();
  return walk.at_end();
}

template <>
bool fits(const MessageBytes& bytes, const features_t&) {
  Walk walk(bytes);
  walk.skip(8 + 4 + 4 + 6 * 8 + 3 * 8 + 4 * 8);
  walk.skip(16 * walk.count());
  walk.skip(25 * walk.count());
  return walk.at_end();
}

template <>
bool fits(const MessageBytes& bytes, const health_t&) {
  Walk walk(bytes);
  walk.skip(8 + 1).text().skip(8 + 3 * 8 + 6 * 8 + 4 + 4 * 4);
  const std::int64_t stages = walk.count();
  walk.texts(stages).skip(8 * stages).skip(8);
  const std::int64_t temperatures = walk.count();
  walk.texts(temperatures).skip(8 * temperatures).texts(4).skip(6 * 8).text();
  return walk.at_end();
}

template <>
bool fits(const MessageBytes& bytes, const images_t&) {
  Walk walk(bytes);
  walk.skip(8);
  const std::int64_t images = walk.count();
  walk.skip(2 * images);
  for (std::int64_t i = 0; i < images && !walk.beyond(); ++i) {
    walk.skip(8 + 4 * 4);
    walk.skip(walk.count());
    const std::int64_t entries = walk.count();
    for (std::int64_t k = 0; k < entries && !walk.beyond(); ++k) {
      walk.text();
      walk.skip(walk.count());
    }
  }
  return walk.at_end();
}

template <>
bool fits(const MessageBytes& bytes, const movers_t&) {
  Walk walk(bytes);
  walk.skip(8 + 8);
  const std::int64_t movers = walk.count();
  for (std::int64_t i = 0; i < movers && !walk.beyond(); ++i) {
    walk.skip(4 + 4 + 1 + 3 * 8 + 3 * 8 + 3 * 8 + 4 * 8 + 36 * 8 + 8 + 4);
    walk.skip(20 * walk.count());
  }
  return walk.at_end();
}

template <>
bool fits(const MessageBytes& bytes, const points_t&) {
  Walk walk(bytes);
  walk.skip(8 + 3 * 8 + 4);
  walk.skip(17 * walk.count());
  return walk.at_end();
}

template <>
bool fits(const MessageBytes& bytes, const status_t&) {
  Walk walk(bytes);
  walk.skip(3 * 8 + 3 + 4 * 4 + 2 * 8 + 1);
  walk.skip(8 * walk.count());
  walk.skip(4 + 3 * 8 + 8 * 4 + 5 * 8 + 8 + 4 + 4 * 8 + 2);
  return walk.at_end();
}

}  // namespace cliquevo::daemon
