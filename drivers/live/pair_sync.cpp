// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/pair_sync.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::drivers {

namespace {

constexpr double kRegular = 0.3;  // periods by which stamps may disagree with sequence numbers
constexpr int kLeastRegular = 3;  // such frames in a row until a stamp that was made on arrival is believed

}  // namespace

PairSync::PairSync(const PairSyncOptions& options)
    : options_(options), period_ns_(1e9 / options.rate_hz), grid_(options), shared_clock_(options) {}

// Whether the stamp can be believed: a late one advances further than the sequence, and the next one less. A frame lost
// on the wire that the camera's count leaves out looks the same at first, and costs a few frames.
bool PairSync::is_regular(Side& s, const SyncFrame& frame) const {
  const double periods = (static_cast<double>(frame.stamp_ns) - static_cast<double>(s.last_stamp_ns)) / period_ns_;
  const double steps = static_cast<double>(frame.sequence) - static_cast<double>(s.last_sequence);
  const bool agree = s.regular >= 0 && steps >= 1.0 && std::abs(periods - steps) <= kRegular;
  s.regular = agree ? std::min(s.regular + 1, kLeastRegular) : 0;
  s.last_stamp_ns = frame.stamp_ns;
  s.last_sequence = frame.sequence;
  return s.regular >= kLeastRegular;
}

void PairSync::expire(CameraSide camera) { grid_.expire(camera, side(other(camera)).lost, books_); }

void PairSync::push(CameraSide camera, const SyncFrame& frame, SyncOutcome& outcome) {
  advance(frame.arrival_ns, outcome);
  Side& mine = side(camera);
  ++books_.counts(camera).received;
  mine.last_arrival_ns = std::max(mine.last_arrival_ns, frame.arrival_ns);
  mine.lost = false;
  if (options_.stamped_on_arrival && !is_regular(mine, frame)) {
    books_.release(camera, {0, frame.stamp_ns, frame.token, false, frame.arrival_ns, false}, SyncLoss::uncertain);
    expire(other(camera));
    return;
  }
  file(camera, frame);
  grid_.pair_up(books_);
  expire(CameraSide::left);
  expire(CameraSide::right);
}

// Gives the frame its number and its place.
void PairSync::file(CameraSide camera, const SyncFrame& frame) {
  const CameraClock::Reading reading = grid_.read(camera, frame, books_);
  const WaitingFrame item{reading.index,    frame.stamp_ns,
                          frame.token,      reading.verdict == CameraClock::Verdict::certain,
                          frame.arrival_ns, reading.verdict != CameraClock::Verdict::uncertain};
  if (reading.verdict == CameraClock::Verdict::doubled) {
    books_.release(camera, item, SyncLoss::doubled);
  } else if (shared_clock_.pair(camera, item, grid_, books_)) {
    // has gone out
  } else if (reading.verdict == CameraClock::Verdict::uncertain) {
    shared_clock_.keep(camera, item, books_);
  } else {
    grid_.wait(camera, item, books_);
  }
  if (reading.confirms) grid_.confirm(camera);
}

void PairSync::advance(std::int64_t now_ns, SyncOutcome& outcome) {
  books_.begin(outcome);
  if (!begun_) {  // both cameras have their time from here
    begun_ = true;
    for (Side& s : sides_) s.last_arrival_ns = now_ns;
  }
  find_lost(now_ns);
}

void PairSync::find_lost(std::int64_t now_ns) {
  for (const CameraSide camera : {CameraSide::left, CameraSide::right}) {
    Side& s = side(camera);
    if (s.lost || static_cast<double>(now_ns - s.last_arrival_ns) * 1e-9 <= options_.lost_after_s) continue;
    s.lost = true;
    grid_.release_all(camera, SyncLoss::unpaired, books_);
    shared_clock_.release_all(books_);
    expire(other(camera));
  }
}

SyncState PairSync::state() const {
  if (sides_[0].lost && sides_[1].lost) return SyncState::both_lost;
  if (sides_[0].lost) return SyncState::left_lost;
  if (sides_[1].lost) return SyncState::right_lost;
  if (!grid_.locked()) return SyncState::acquiring;
  if (grid_.out_of_phase()) return SyncState::out_of_phase;
  return grid_.related() ? SyncState::synchronised : SyncState::acquiring;
}

}  // namespace cliquevo::drivers
