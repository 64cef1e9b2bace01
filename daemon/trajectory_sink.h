// SPDX-License-Identifier: BSD-3-Clause
// Writes the trajectory on a thread of its own, so that a slow disk delays no message.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "core/base/time.h"

namespace cliquevo::daemon {

class TrajectorySink {
 public:
  // KITTI format, a line a pose, as `cliquevo replay --trajectory` writes it.
  static Result<TrajectorySink> open(const std::string& path);
  TrajectorySink(TrajectorySink&&) noexcept;
  TrajectorySink& operator=(TrajectorySink&&) = delete;
  ~TrajectorySink();

  // One thread. Never waits for the disk.
  void append(TimestampNs stamp_ns, const RigidTransform& T_world_camera);
  // Writes what is left. An error if a pose could not be written or had to be left out.
  Result<void> close();

 private:
  struct Impl;
  explicit TrajectorySink(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
