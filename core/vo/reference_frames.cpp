// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/reference_frames.h"

#include <algorithm>

namespace cliquevo::vo {

ReferenceFrames::ReferenceFrames(const StereoModel& model, const VoParams& params) {
  constexpr std::size_t kRoles = 3 + kOlder;
  for (std::size_t i = 0; i < kRoles + 1; ++i) {  // and the current one
    frames_.emplace_back(std::make_unique<Frame>(params));
    frames_.back()->left.resize(model.width, model.height);
    frames_.back()->right.resize(model.width, model.height);
  }
  clear();
}

void ReferenceFrames::clear() {
  valid_ = key_ = failed_ = nullptr;
  older_.fill(nullptr);
  older_covariance_.fill(Matrix6d::Zero());
  valid_covariance_.setZero();
}

bool ReferenceFrames::in_use(const Frame* frame) const {
  return frame == valid_ || frame == key_ || frame == failed_ ||
         std::find(older_.begin(), older_.end(), frame) != older_.end();
}

Frame* ReferenceFrames::spare() {
  for (const auto& frame : frames_) {
    if (!in_use(frame.get())) return frame.get();
  }
  return nullptr;  // one frame more than there are roles
}

const Matrix6d& ReferenceFrames::covariance_to_valid(const Frame& reference) const {
  sum_.setZero();
  if (&reference == valid_) return sum_;
  sum_ = valid_covariance_;
  for (std::size_t i = 0; i < kOlder; ++i) {
    if (older_[i] == &reference) sum_ += older_covariance_[i];
  }
  return sum_;
}

void ReferenceFrames::accept(Frame* current, const Matrix6d& covariance, bool new_key) {
  valid_covariance_ = covariance;
  if (new_key) {
    if (key_ != nullptr) {
      std::rotate(older_.begin(), older_.end() - 1, older_.end());
      std::rotate(older_covariance_.begin(), older_covariance_.end() - 1, older_covariance_.end());
      older_[0] = key_;
      older_covariance_[0].setZero();
    }
    for (Matrix6d& to_key : older_covariance_) to_key += covariance;
    valid_covariance_.setZero();
    key_ = current;
  }
  valid_ = current;
  failed_ = nullptr;
}

}  // namespace cliquevo::vo
