// SPDX-License-Identifier: BSD-3-Clause
// Pairs into an MCAP by a thread of its own, so that a slow disk does not hold up a camera.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "drivers/frame_source.h"
#include "drivers/recorder.h"

namespace cliquevo::tools {

class BagRecorder {
 public:
  // wait_when_full: hold up who adds pairs instead of leaving them out.
  static Result<BagRecorder> start(const std::string& path, bool wait_when_full, const drivers::SourceInfo& info,
                                   const RigidTransform& T_body_camera);
  BagRecorder(BagRecorder&&) noexcept;
  BagRecorder& operator=(BagRecorder&&) noexcept;
  ~BagRecorder();

  // Copies it.
  void add(const drivers::StereoPair& pair);
  drivers::RecorderCounts counts() const;
  std::optional<Error> failure() const;
  // Writes what is queued, and the summary.
  Result<void> stop();

 private:
  struct Impl;
  explicit BagRecorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::tools
