// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/numbered_grid.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::drivers {

namespace {

constexpr std::size_t kMostWaiting = 80;       // more than are ever held unconfirmed
constexpr std::int64_t kReorderDepth = 2;      // numbers behind which a partner is given up
constexpr double kInPhaseAtFirst = 0.3;        // periods: what the learnt delays are good to
constexpr double kInPhase = 0.4;               // periods: beyond it a number of ours must be wrong
constexpr std::int64_t kDriftFrames = 1000;    // base of the drift's estimate ...
constexpr std::int64_t kDriftRestart = 20000;  // ... which begins anew now and then, as drift changes with warmth

}  // namespace

NumberedGrid::NumberedGrid(const PairSyncOptions& options)
    : triggered_(options.triggered),
      shared_clock_(options.shared_clock),
      tolerance_(options.tolerance),
      period_ns_(1e9 / options.rate_hz),
      sides_{Side(period_ns_), Side(period_ns_)} {
  for (Side& s : sides_) s.waiting.reserve(kMostWaiting + 1);
}

CameraClock::Reading NumberedGrid::read(CameraSide camera, const SyncFrame& frame, SyncBooks& books) {
  const CameraClock::Reading reading = side(camera).clock.read(frame.stamp_ns, frame.arrival_ns);
  books.counts(camera).missing += reading.missing;
  if (reading.out_of_order) ++books.counts(camera).out_of_order;
  if (reading.restarted) void_numbers(camera, books);
  return reading;
}

void NumberedGrid::wait(CameraSide camera, const WaitingFrame& frame, SyncBooks& books) {
  Side& mine = side(camera);
  if (mine.any_paired && frame.index <= mine.last_paired) {
    books.release(camera, frame, SyncLoss::late);
    return;
  }
  const auto at = std::find_if(mine.waiting.begin(), mine.waiting.end(),
                               [&](const WaitingFrame& w) { return w.index > frame.index; });
  mine.waiting.insert(at, frame);
}

void NumberedGrid::confirm(CameraSide camera) {
  for (WaitingFrame& w : side(camera).waiting) w.certain = true;
}

void NumberedGrid::release_all(CameraSide camera, SyncLoss why, SyncBooks& books) {
  for (const WaitingFrame& frame : side(camera).waiting) books.release(camera, frame, why);
  side(camera).waiting.clear();
}

// Removes a frame that was paired, and hands back the older ones of its camera.
void NumberedGrid::take_out(CameraSide camera, const WaitingFrame& frame, SyncBooks& books) {
  Side& s = side(camera);
  release_below(camera, frame.index, books);
  if (!s.waiting.empty() && s.waiting.front().token == frame.token) s.waiting.erase(s.waiting.begin());
  s.any_paired = true;
  s.last_paired = frame.index;
}

void NumberedGrid::release_below(CameraSide camera, std::int64_t index, SyncBooks& books) {
  std::vector<WaitingFrame>& waiting = side(camera).waiting;
  const auto end =
      std::find_if(waiting.begin(), waiting.end(), [&](const WaitingFrame& w) { return w.index >= index; });
  for (auto it = waiting.begin(); it != end; ++it) books.release(camera, *it, SyncLoss::unpaired);
  waiting.erase(waiting.begin(), end);
}

void NumberedGrid::forget_relation() {
  relation_.reset();
  drift_begun_ = false;
  drift_ppm_.reset();
}

// What a camera's numbers meant is lost.
void NumberedGrid::void_numbers(CameraSide camera, SyncBooks& books) {
  ++books.counts(camera).clock_steps;
  side(camera).any_paired = false;
  release_all(camera, SyncLoss::uncertain, books);
  release_all(other(camera), SyncLoss::unpaired,
              books);  // they waited for numbers that are no more
  forget_relation();
}

// Right exposure - left exposure on the host's clock (or on the shared one), by the grids.
double NumberedGrid::difference_ns(std::int64_t left_index, std::int64_t right_index) const {
  const CameraClock& l = sides_[0].clock;
  const CameraClock& r = sides_[1].clock;
  double difference = r.grid_ns(right_index) - l.grid_ns(left_index);
  const std::int64_t bases = r.base_ns() - l.base_ns();
  if (shared_clock_) return difference + static_cast<double>(bases);
  // Integers first: they cancel but for the clocks' difference.
  return difference + r.delay_ns() - l.delay_ns() +
         static_cast<double>(bases + (r.base_delay_ns() - l.base_delay_ns()));
}

// Which numbers belong together: those whose exposures are nearest.
void NumberedGrid::relate(SyncBooks& books) {
  CameraClock& l = sides_[0].clock;
  CameraClock& r = sides_[1].clock;
  if (!l.locked() || !r.locked()) return;
  const bool fixed = triggered_;  // one trigger: the numbers count the same events for ever
  if (fixed && relation_) {
    if (std::abs(difference_ns(l.newest(), l.newest() + *relation_)) <= kInPhase * period_ns_) return;
    for (const CameraSide camera : {CameraSide::left, CameraSide::right}) {
      side(camera).clock.restart();
      void_numbers(camera, books);
    }
    return;
  }
  const double now_ns = difference_ns(l.newest(), r.newest());
  const double period_ns = r.period_ns();
  const std::int64_t behind = std::llround(now_ns / period_ns);
  const std::int64_t relation = r.newest() - behind - l.newest();
  const double phase_ns = now_ns - static_cast<double>(behind) * period_ns;
  const double most = fixed && !shared_clock_ ? kInPhaseAtFirst : tolerance_;
  out_of_phase_ = std::abs(phase_ns) > most * period_ns_;
  if (shared_clock_) {  // a clock that is not shared after all shows in the arrivals
    const double delays = r.delay_ns() - l.delay_ns() + static_cast<double>(r.base_delay_ns() - l.base_delay_ns());
    out_of_phase_ = out_of_phase_ || std::abs(delays) > 0.5 * period_ns_;
  }
  if (out_of_phase_) {
    if (relation_) forget_relation();
    return;
  }
  if (relation_ && *relation_ != relation) forget_relation();
  relation_ = relation;
}

void NumberedGrid::follow_drift(std::int64_t left_index) {
  const CameraClock& l = sides_[0].clock;
  const CameraClock& r = sides_[1].clock;
  if (!triggered_) return;  // the grids then follow the cameras' paces, not one trigger
  const double offset_ns = r.grid_ns(left_index + *relation_) - l.grid_ns(left_index);
  if (!drift_begun_ || left_index - drift_index_ > kDriftRestart) {
    drift_begun_ = true;
    drift_index_ = left_index;
    drift_offset_ns_ = offset_ns;
    return;
  }
  if (left_index - drift_index_ < kDriftFrames) return;
  drift_ppm_ = 1e6 * (offset_ns - drift_offset_ns_) / (static_cast<double>(left_index - drift_index_) * l.period_ns());
}

// Each stamp against its grid; the grids against each other only where their clocks are comparable.
std::int64_t NumberedGrid::skew_ns(const WaitingFrame& left, const WaitingFrame& right) const {
  const CameraClock& l = sides_[0].clock;
  const CameraClock& r = sides_[1].clock;
  const double left_ns = static_cast<double>(left.stamp_ns - l.base_ns()) - l.grid_ns(left.index);
  const double right_ns = static_cast<double>(right.stamp_ns - r.base_ns()) - r.grid_ns(right.index);
  double skew_ns = right_ns - left_ns;
  if (shared_clock_ || !triggered_) skew_ns += difference_ns(left.index, right.index);
  return std::llround(skew_ns);
}

// All pairs that are certain, in order; what they leave behind can no more be paired.
void NumberedGrid::pair_up(SyncBooks& books) {
  relate(books);
  if (!relation_) return;
  std::vector<WaitingFrame>& left = sides_[0].waiting;
  std::vector<WaitingFrame>& right = sides_[1].waiting;
  for (bool again = true; again;) {
    again = false;
    for (const WaitingFrame& l : left) {
      const auto r = std::find_if(right.begin(), right.end(),
                                  [&](const WaitingFrame& w) { return w.index == l.index + *relation_; });
      if (r == right.end() || !l.certain || !r->certain) continue;
      const WaitingFrame left_frame = l;
      const WaitingFrame right_frame = *r;
      take_out(CameraSide::left, left_frame, books);
      take_out(CameraSide::right, right_frame, books);
      books.pair(left_frame, right_frame, skew_ns(left_frame, right_frame));
      follow_drift(left_frame.index);
      again = true;
      break;
    }
  }
}

// Frames whose partner will not come any more.
void NumberedGrid::expire(CameraSide camera, bool partner_lost, SyncBooks& books) {
  Side& mine = side(camera);
  const Side& theirs = side(other(camera));
  if (relation_ && theirs.clock.locked()) {
    const std::int64_t to_theirs = camera == CameraSide::left ? *relation_ : -*relation_;
    const auto gone = [&](const WaitingFrame& w) {
      const std::int64_t partner = w.index + to_theirs;
      if (partner >= theirs.clock.newest() - kReorderDepth) return false;
      if (std::any_of(theirs.waiting.begin(), theirs.waiting.end(),
                      [&](const WaitingFrame& t) { return t.index == partner; })) {
        return false;  // it is there, held
      }
      books.release(camera, w, SyncLoss::unpaired);
      return true;
    };
    mine.waiting.erase(std::remove_if(mine.waiting.begin(), mine.waiting.end(), gone), mine.waiting.end());
  }
  while (mine.waiting.size() > kMostWaiting || (partner_lost && !mine.waiting.empty())) {
    books.release(camera, mine.waiting.front(), SyncLoss::unpaired);
    mine.waiting.erase(mine.waiting.begin());
  }
}

std::optional<std::int64_t> NumberedGrid::clock_offset_ns() const {
  if (!relation_) return std::nullopt;
  const CameraClock& l = sides_[0].clock;
  const CameraClock& r = sides_[1].clock;
  const double grids_ns = r.grid_ns(l.newest() + *relation_) - l.grid_ns(l.newest());
  return r.base_ns() - l.base_ns() + std::llround(grids_ns);
}

}  // namespace cliquevo::drivers
