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

void PairSync::expire(Eye eye) { grid_.expire(eye, side(other(eye)).lost, books_); }

void PairSync::push(Eye eye, const SyncFrame& frame, SyncOutcome& outcome) {
  advance(frame.arrival_ns, outcome);
  Side& mine = side(eye);
  ++books_.counts(eye).received;
  mine.last_arrival_ns = std::max(mine.last_arrival_ns, frame.arrival_ns);
  mine.lost = false;
  if (options_.stamped_on_arrival && !is_regular(mine, frame)) {
    books_.release(eye, {0, frame.stamp_ns, frame.token, false, frame.arrival_ns, false}, SyncLoss::uncertain);
    expire(other(eye));
    return;
  }
  file(eye, frame);
  grid_.pair_up(books_);
  expire(Eye::left);
  expire(Eye::right);
}

// Gives the frame its number and its place.
void PairSync::file(Eye eye, const SyncFrame& frame) {
  const EyeClock::Reading reading = grid_.read(eye, frame, books_);
  const WaitingFrame item{reading.index,    frame.stamp_ns,
                          frame.token,      reading.verdict == EyeClock::Verdict::certain,
                          frame.arrival_ns, reading.verdict != EyeClock::Verdict::uncertain};
  if (reading.verdict == EyeClock::Verdict::doubled) {
    books_.release(eye, item, SyncLoss::doubled);
  } else if (shared_clock_.pair(eye, item, grid_, books_)) {
    // has gone out
  } else if (reading.verdict == EyeClock::Verdict::uncertain) {
    shared_clock_.keep(eye, item, books_);
  } else {
    grid_.wait(eye, item, books_);
  }
  if (reading.confirms) grid_.confirm(eye);
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
  for (const Eye eye : {Eye::left, Eye::right}) {
    Side& s = side(eye);
    if (s.lost || static_cast<double>(now_ns - s.last_arrival_ns) * 1e-9 <= options_.lost_after_s) continue;
    s.lost = true;
    grid_.release_all(eye, SyncLoss::unpaired, books_);
    shared_clock_.release_all(books_);
    expire(other(eye));
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
