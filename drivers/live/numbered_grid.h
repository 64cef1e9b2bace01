// SPDX-License-Identifier: BSD-3-Clause
// Pairs by number: a camera's stamps give its frames numbers on a grid of exposures (CameraClock), and which number of
// the left camera belongs to which of the right is learnt from the arrivals.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/live/camera_clock.h"
#include "drivers/live/sync_books.h"

namespace cliquevo::drivers {

class NumberedGrid {
 public:
  explicit NumberedGrid(const PairSyncOptions& options);

  // A frame's number; when the numbers of its camera begin anew, what waits for the old ones is handed back.
  CameraClock::Reading read(CameraSide camera, const SyncFrame& frame, SyncBooks& books);
  // Keeps a numbered frame until its partner comes; hands it back when that is too late.
  void wait(CameraSide camera, const WaitingFrame& frame, SyncBooks& books);
  // All that waits of this camera is what it was held to be.
  void confirm(CameraSide camera);
  // Gives out all pairs that are certain, in order; what they leave behind can no more be paired.
  void pair_up(SyncBooks& books);
  // Hands back frames whose partner will not come any more. partner_lost: the other camera sends nothing.
  void expire(CameraSide camera, bool partner_lost, SyncBooks& books);
  void release_all(CameraSide camera, SyncLoss why, SyncBooks& books);
  // The frame went out in a pair that was found otherwise: older ones of its camera are handed back.
  void take_out(CameraSide camera, const WaitingFrame& frame, SyncBooks& books);

  const std::vector<WaitingFrame>& waiting(CameraSide camera) const { return side(camera).waiting; }
  bool locked() const { return sides_[0].clock.locked() && sides_[1].clock.locked(); }
  bool related() const { return relation_.has_value(); }
  bool out_of_phase() const { return out_of_phase_; }
  std::optional<std::int64_t> clock_offset_ns() const;
  std::optional<double> clock_drift_ppm() const { return drift_ppm_; }

 private:
  struct Side {
    explicit Side(double period_ns) : clock(period_ns) {}
    CameraClock clock;
    std::vector<WaitingFrame> waiting;  // in order of their numbers
    std::int64_t last_paired = 0;
    bool any_paired = false;  // since this camera's numbers began
  };

  Side& side(CameraSide camera) { return sides_[static_cast<std::size_t>(camera)]; }
  const Side& side(CameraSide camera) const { return sides_[static_cast<std::size_t>(camera)]; }
  void release_below(CameraSide camera, std::int64_t index, SyncBooks& books);
  void forget_relation();
  void void_numbers(CameraSide camera, SyncBooks& books);
  void relate(SyncBooks& books);
  double difference_ns(std::int64_t left_index, std::int64_t right_index) const;
  std::int64_t skew_ns(const WaitingFrame& left, const WaitingFrame& right) const;
  void follow_drift(std::int64_t left_index);

  bool triggered_;
  bool shared_clock_;
  double tolerance_;
  double period_ns_;
  std::array<Side, 2> sides_;
  std::optional<std::int64_t> relation_;  // right number - left number of one exposure
  bool out_of_phase_ = false;
  std::int64_t drift_index_ = 0;  // left number and offset that the drift is measured from
  double drift_offset_ns_ = 0.0;
  bool drift_begun_ = false;
  std::optional<double> drift_ppm_;
};

}  // namespace cliquevo::drivers
