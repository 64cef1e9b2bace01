// SPDX-License-Identifier: BSD-3-Clause
// The daemon's recording: started and stopped while frames flow.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "daemon/pipeline/config.h"
#include "drivers/frame_source.h"
#include "drivers/recorder.h"

namespace cliquevo::daemon {

class Recording {
 public:
  // lossless: who adds pairs waits for the disk (a source played as fast as it goes); else pairs are left out.
  Recording(const RecordingConfig& config, const drivers::SourceInfo& info, bool lossless);
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  // Any thread. start() while one is written, stop() while none is: nothing happens.
  Result<void> start();
  Result<void> stop();
  bool active() const;
  // Any thread. From the next start() on.
  void configure(const RecordingConfig& config);
  // Any thread; nothing happens while no recording is written.
  void add(const drivers::StereoPair& pair);
  void add(const std::string& channel, const std::uint8_t* data, std::size_t size);
  // About once a second: logs a failure, once. One line on what is written; empty = nothing is.
  std::string status();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Hands out what `source` delivers, and records it.
std::unique_ptr<drivers::FrameSource> record_pairs(std::unique_ptr<drivers::FrameSource> source, Recording& recording);

}  // namespace cliquevo::daemon
