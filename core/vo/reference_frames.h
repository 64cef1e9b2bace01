// SPDX-License-Identifier: BSD-3-Clause
// The frames that the current one may be compared with, and how uncertain the way between them is.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/vo/frame.h"

namespace cliquevo::vo {

class ReferenceFrames {
 public:
  static constexpr std::size_t kOlder = 3;

  ReferenceFrames(const StereoModel& model, const VoParams& params);

  // A frame that serves no role: the next current one.
  Frame* spare();
  void clear();

  Frame* valid() const { return valid_; }    // last frame with a valid motion (or the first one)
  Frame* key() const { return key_; }        // kept for as long as enough of its features are found
  Frame* failed() const { return failed_; }  // last frame, where it failed
  // Frames of the way before the key frame, the newest first; some may be null.
  const std::array<Frame*, kOlder>& older() const { return older_; }
  const Frame& last() const { return failed_ != nullptr ? *failed_ : *valid_; }

  // Covariance of where the last valid frame is, seen from one of the above (not the failed one).
  const Matrix6d& covariance_to_valid(const Frame& reference) const;

  // The current frame becomes the last valid one: known to `covariance` as seen from the frames it was compared with.
  // new_key: and the kept one.
  void accept(Frame* current, const Matrix6d& covariance, bool new_key);
  void refuse(Frame* current) { failed_ = current; }

 private:
  bool in_use(const Frame* frame) const;

  std::vector<std::unique_ptr<Frame>> frames_;
  Frame* valid_ = nullptr;
  Frame* key_ = nullptr;
  Frame* failed_ = nullptr;
  std::array<Frame*, kOlder> older_{};
  std::array<Matrix6d, kOlder> older_covariance_{};  // of the key frame, seen from each
  mutable Matrix6d sum_ = Matrix6d::Zero();
  Matrix6d valid_covariance_ = Matrix6d::Zero();  // of the last valid frame, seen from the key frame
};

}  // namespace cliquevo::vo
