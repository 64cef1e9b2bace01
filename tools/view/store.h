// SPDX-License-Identifier: BSD-3-Clause
// What the page can look at: a record a frame in memory, pictures in a file without a name. Both have a most: then the
// oldest go.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/view/facts.h"
#include "tools/view/pictures.h"

namespace cliquevo::view {

// A frame's pictures; any may be empty.
struct FrameParts {
  Bytes features;
  Bytes left;
  Bytes right;
  Bytes disparity;
  float disparity_step_px = 0.25F;
};

// Which of them somebody wants.
enum PartMask : unsigned { kFeatures = 1, kLeft = 2, kRight = 4, kDisparity = 8 };

class Store {
 public:
  // most_bytes: of pictures; most_records: of frames. Fails when no file can be made in TMPDIR (/var/tmp).
  static Result<std::unique_ptr<Store>> make(std::int64_t most_bytes, std::size_t most_records);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  // The feeding thread. Pictures that cannot be written are left out and counted.
  void add(const FrameFacts& facts, const FrameParts& parts);
  // Adds the left image or disparity of a frame that was added before; false: it is gone, or none has this stamp.
  bool add_pictures(std::int64_t stamp_us, const FrameParts& parts);

  // Any thread, all below.
  struct Extent {
    std::int64_t first = 0;  // number of the oldest record
    std::int64_t end = 0;    // of the one to come
    std::int64_t lost_pictures = 0;
  };
  Extent extent() const;
  // Records [from, ...) as JSON with commas between, `most` at most; `from` moves behind them.
  std::string records(std::int64_t& from, std::size_t most) const;
  // The message that the page takes for a frame's pictures (tools/view/page/frame.js); empty parts where they are gone.
  // have: frame whose images the page has already: they are not sent again; -1: none.
  std::string frame_message(std::int64_t number, unsigned parts, std::int64_t have = -1) const;

 private:
  struct Span {
    std::int64_t begin = 0;  // in all that was ever written
    std::uint32_t size = 0;
  };
  struct Entry {
    std::int64_t stamp_us = 0;
    std::string record;
    Span parts[4];
    float disparity_step_px = 0.25F;
  };
  Store(int file, std::int64_t most_bytes, std::size_t most_records);
  Span write(const Bytes& bytes);
  bool read(const Span& span, char* to) const;
  std::size_t last_with_picture(std::size_t at) const;

  const int file_;
  const std::int64_t most_bytes_;
  const std::size_t most_records_;
  mutable std::mutex mutex_;
  std::deque<Entry> entries_;
  std::int64_t first_ = 0;
  std::int64_t written_ = 0;
  std::int64_t lost_pictures_ = 0;
};

}  // namespace cliquevo::view
