// SPDX-License-Identifier: BSD-3-Clause
// Noise-free renders on disk, one file a pair: 12 bits a pixel, packed, with a checksum. Only files of this user's are
// read (drivers/own_folder.h); in a folder that others may write into, ours is the folder user-UID.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/own_folder.h"
#include "drivers/simulator.h"
#include "drivers/simulator/renderer.h"

namespace cliquevo::drivers::sim {

// The options that decide what a render looks like, one "key=value" a line, render version first.
std::string render_key(const SimulatorOptions& options);

class RenderCache {
 public:
  // Below options.cache_dir ("none": every call misses). A folder that cannot be written is as no cache. Makes room
  // first when the store is above options.cache_limit_gb: the scene folders not used for longest
  // go, none but those that a RenderCache made.
  explicit RenderCache(const SimulatorOptions& options);

  bool enabled() const { return folder_.has_value(); }
  // false: not there, or torn (then it is rendered again). Both are safe from several threads and processes.
  bool load(std::int64_t frame, CleanPair& pair) const;
  void store(std::int64_t frame, const CleanPair& pair) const;

 private:
  std::optional<OwnFolder> folder_;
  int width_, height_;
  std::int64_t room_bytes_ = 0;
  mutable std::atomic<std::int64_t> written_{0};
};

}  // namespace cliquevo::drivers::sim
