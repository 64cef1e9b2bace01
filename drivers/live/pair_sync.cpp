// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/pair_sync.h"

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

// Arrivals scatter by +-0.4 periods: frames of different exposures, whole periods apart, are never nearer than this.
constexpr double kTogether = 0.2;
constexpr std::size_t kMostUnnumbered = 4;
// Frames of one stamp that came together speak for a shared clock, those that came apart against it, and more so.
constexpr int kTogetherTells = 1;
constexpr int kApartTells = 2;
constexpr int kMostTrust = 4;
constexpr int kLeastTrust = -8;
constexpr double kRegular = 0.3;  // periods by which stamps may disagree with sequence numbers
constexpr int kLeastRegular = 3;  // such frames in a row until a stamp that was made on arrival is believed

Eye other(Eye eye) { return eye == Eye::left ? Eye::right : Eye::left; }

}  // namespace

Result<void> PairSyncOptions::check() const {
  if (!(rate_hz >= 0.01 && rate_hz <= 10000.0)) {
    return Error{"frame rate is out of 0.01 to 10000 Hz", "pair synchronisation", "give the rate of the cameras"};
  }
  if (!(tolerance > 0.0 && tolerance <= 0.3)) {
    return Error{"pair tolerance is out of 0 to 0.3 periods", "pair synchronisation", "give 0.25 or less"};
  }
  if (!(lost_after_s > 0.0 && lost_after_s <= 3600.0)) {
    return Error{"lost_after is out of 0 to 3600 s", "pair synchronisation", "give it in seconds"};
  }
  return {};
}

PairSync::PairSync(const PairSyncOptions& options)
    : options_(options), period_ns_(1e9 / options.rate_hz), sides_{Side(period_ns_), Side(period_ns_)} {
  for (Side& s : sides_) {
    s.waiting.reserve(kMostWaiting + 1);
    s.unnumbered.reserve(kMostUnnumbered + 1);
  }
}

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

void PairSync::release(Eye eye, const Waiting& frame, SyncLoss why, SyncOutcome& outcome) {
  SyncCounts& counts = side(eye).counts;
  switch (why) {
    case SyncLoss::unpaired:
      ++counts.unpaired;
      break;
    case SyncLoss::late:
      ++counts.late;
      break;
    case SyncLoss::doubled:
      ++counts.doubled;
      break;
    case SyncLoss::uncertain:
      ++counts.uncertain;
      break;
  }
  outcome.released.push_back({eye, frame.token, why});
}

void PairSync::release_all(Eye eye, SyncLoss why, SyncOutcome& outcome) {
  for (const Waiting& frame : side(eye).waiting) release(eye, frame, why, outcome);
  side(eye).waiting.clear();
}

// Removes a frame that was paired, and hands back the older ones of its eye.
void PairSync::take_out(Eye eye, const Waiting& frame, SyncOutcome& outcome) {
  Side& s = side(eye);
  if (frame.numbered) {
    release_below(eye, frame.index, outcome);
    if (!s.waiting.empty() && s.waiting.front().token == frame.token) s.waiting.erase(s.waiting.begin());
    s.any_paired = true;
    s.last_paired = frame.index;
  }
  const auto gone = [&](const Waiting& w) {
    if (w.token == frame.token) return true;
    if (w.stamp_ns > frame.stamp_ns) return false;
    release(eye, w, SyncLoss::uncertain, outcome);
    return true;
  };
  s.unnumbered.erase(std::remove_if(s.unnumbered.begin(), s.unnumbered.end(), gone), s.unnumbered.end());
}

// On a shared clock: the partner that has the same stamp, if it also came at the same time. A clock that is shared by
// name alone brings it whole periods apart, every time: this way is then closed, and the clocks must have been learnt.
// A stalled host brings it apart now and then.
bool PairSync::pair_by_stamp(Eye eye, const Waiting& frame, SyncOutcome& outcome) {
  if (!options_.shared_clock) return false;
  const auto is_partner = [&](const Waiting& w) {
    return std::abs(static_cast<double>(w.stamp_ns) - static_cast<double>(frame.stamp_ns)) <=
           options_.tolerance * period_ns_;
  };
  const Side& theirs = side(other(eye));
  const Waiting* found = nullptr;
  for (const std::vector<Waiting>* list : {&theirs.waiting, &theirs.unnumbered}) {
    const auto w = std::find_if(list->begin(), list->end(), is_partner);
    if (w != list->end()) found = &*w;
  }
  if (found == nullptr) return false;
  const Waiting partner = *found;
  if (std::abs(static_cast<double>(partner.arrival_ns - frame.arrival_ns)) > kTogether * period_ns_) {
    trust_ = std::max(trust_ - kApartTells, kLeastTrust);
    return false;
  }
  trust_ = std::min(trust_ + kTogetherTells, kMostTrust);
  if (trust_ < 0) return false;
  const Waiting& left = eye == Eye::left ? frame : partner;
  const Waiting& right = eye == Eye::left ? partner : frame;
  if (last_stamp_ns_ && left.stamp_ns <= *last_stamp_ns_) return false;
  take_out(Eye::left, left, outcome);
  take_out(Eye::right, right, outcome);
  last_stamp_ns_ = left.stamp_ns;
  outcome.pairs.push_back({left.token, right.token, left.stamp_ns, right.stamp_ns - left.stamp_ns});
  for (Side& s : sides_) ++s.counts.paired;
  return true;
}

void PairSync::keep_unnumbered(Eye eye, const Waiting& frame, SyncOutcome& outcome) {
  std::vector<Waiting>& list = side(eye).unnumbered;
  const bool of_use = options_.shared_clock && !(last_stamp_ns_ && frame.stamp_ns <= *last_stamp_ns_);
  if (of_use && list.size() == kMostUnnumbered) {
    release(eye, list.front(), SyncLoss::uncertain, outcome);
    list.erase(list.begin());
  }
  if (of_use) {
    list.push_back(frame);
  } else {
    release(eye, frame, SyncLoss::uncertain, outcome);
  }
}

void PairSync::release_below(Eye eye, std::int64_t index, SyncOutcome& outcome) {
  std::vector<Waiting>& waiting = side(eye).waiting;
  const auto end = std::find_if(waiting.begin(), waiting.end(), [&](const Waiting& w) { return w.index >= index; });
  for (auto it = waiting.begin(); it != end; ++it) release(eye, *it, SyncLoss::unpaired, outcome);
  waiting.erase(waiting.begin(), end);
}

void PairSync::forget_relation() {
  relation_.reset();
  drift_begun_ = false;
  drift_ppm_.reset();
}

// What the eye's numbers meant is lost.
void PairSync::void_numbers(Eye eye, SyncOutcome& outcome) {
  Side& s = side(eye);
  ++s.counts.clock_steps;
  s.any_paired = false;
  release_all(eye, SyncLoss::uncertain, outcome);
  release_all(other(eye), SyncLoss::unpaired, outcome);  // they waited for numbers that are no more
  forget_relation();
}

// Right exposure - left exposure on the host's clock (or on the shared one), by the grids.
double PairSync::difference_ns(std::int64_t left_index, std::int64_t right_index) const {
  const EyeClock& l = sides_[0].clock;
  const EyeClock& r = sides_[1].clock;
  double difference = r.grid_ns(right_index) - l.grid_ns(left_index);
  const std::int64_t bases = r.base_ns() - l.base_ns();
  if (options_.shared_clock) return difference + static_cast<double>(bases);
  // Integers first: they cancel but for the clocks' difference.
  return difference + r.delay_ns() - l.delay_ns() +
         static_cast<double>(bases + (r.base_delay_ns() - l.base_delay_ns()));
}

// Which numbers belong together: those whose exposures are nearest.
void PairSync::relate(SyncOutcome& outcome) {
  EyeClock& l = sides_[0].clock;
  EyeClock& r = sides_[1].clock;
  if (!l.locked() || !r.locked()) return;
  const bool fixed = options_.triggered;  // one trigger: the numbers count the same events for ever
  if (fixed && relation_) {
    if (std::abs(difference_ns(l.newest(), l.newest() + *relation_)) <= kInPhase * period_ns_) return;
    for (const Eye eye : {Eye::left, Eye::right}) {
      side(eye).clock.restart();
      void_numbers(eye, outcome);
    }
    return;
  }
  const double now_ns = difference_ns(l.newest(), r.newest());
  const double period_ns = r.period_ns();
  const std::int64_t behind = std::llround(now_ns / period_ns);
  const std::int64_t relation = r.newest() - behind - l.newest();
  const double phase_ns = now_ns - static_cast<double>(behind) * period_ns;
  const double most = fixed && !options_.shared_clock ? kInPhaseAtFirst : options_.tolerance;
  out_of_phase_ = std::abs(phase_ns) > most * period_ns_;
  if (options_.shared_clock) {  // a clock that is not shared after all shows in the arrivals
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

void PairSync::follow_drift(std::int64_t left_index) {
  const EyeClock& l = sides_[0].clock;
  const EyeClock& r = sides_[1].clock;
  if (!options_.triggered) return;  // the grids then follow the cameras' paces, not one trigger
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

void PairSync::emit(const Waiting& left, const Waiting& right, SyncOutcome& outcome) {
  const EyeClock& l = sides_[0].clock;
  const EyeClock& r = sides_[1].clock;
  // Each stamp against its grid; the grids against each other only where their clocks are comparable.
  const double left_ns = static_cast<double>(left.stamp_ns - l.base_ns()) - l.grid_ns(left.index);
  const double right_ns = static_cast<double>(right.stamp_ns - r.base_ns()) - r.grid_ns(right.index);
  double skew_ns = right_ns - left_ns;
  if (options_.shared_clock || !options_.triggered) skew_ns += difference_ns(left.index, right.index);
  outcome.pairs.push_back({left.token, right.token, left.stamp_ns, std::llround(skew_ns)});
  for (Side& s : sides_) {
    ++s.counts.paired;
    s.any_paired = true;
  }
  sides_[0].last_paired = left.index;
  sides_[1].last_paired = right.index;
  last_stamp_ns_ = left.stamp_ns;
  follow_drift(left.index);
}

// All pairs that are certain, in order; what they leave behind can no more be paired.
void PairSync::pair_up(SyncOutcome& outcome) {
  if (!relation_) return;
  std::vector<Waiting>& left = sides_[0].waiting;
  std::vector<Waiting>& right = sides_[1].waiting;
  for (bool again = true; again;) {
    again = false;
    for (const Waiting& l : left) {
      const auto r =
          std::find_if(right.begin(), right.end(), [&](const Waiting& w) { return w.index == l.index + *relation_; });
      if (r == right.end() || !l.certain || !r->certain) continue;
      const Waiting left_frame = l;
      const Waiting right_frame = *r;
      release_below(Eye::left, left_frame.index, outcome);
      release_below(Eye::right, right_frame.index, outcome);
      left.erase(left.begin());
      right.erase(right.begin());
      emit(left_frame, right_frame, outcome);
      again = true;
      break;
    }
  }
}

// Frames whose partner will not come any more.
void PairSync::expire(Eye eye, SyncOutcome& outcome) {
  Side& mine = side(eye);
  const Side& theirs = side(other(eye));
  if (relation_ && theirs.clock.locked()) {
    const std::int64_t to_theirs = eye == Eye::left ? *relation_ : -*relation_;
    const auto gone = [&](const Waiting& w) {
      const std::int64_t partner = w.index + to_theirs;
      if (partner >= theirs.clock.newest() - kReorderDepth) return false;
      if (std::any_of(theirs.waiting.begin(), theirs.waiting.end(),
                      [&](const Waiting& t) { return t.index == partner; })) {
        return false;  // it is there, held
      }
      release(eye, w, SyncLoss::unpaired, outcome);
      return true;
    };
    mine.waiting.erase(std::remove_if(mine.waiting.begin(), mine.waiting.end(), gone), mine.waiting.end());
  }
  while (mine.waiting.size() > kMostWaiting || (theirs.lost && !mine.waiting.empty())) {
    release(eye, mine.waiting.front(), SyncLoss::unpaired, outcome);
    mine.waiting.erase(mine.waiting.begin());
  }
}

void PairSync::push(Eye eye, const SyncFrame& frame, SyncOutcome& outcome) {
  Side& mine = side(eye);
  advance(frame.arrival_ns, outcome);
  ++mine.counts.received;
  mine.last_arrival_ns = std::max(mine.last_arrival_ns, frame.arrival_ns);
  mine.lost = false;
  if (options_.stamped_on_arrival && !is_regular(mine, frame)) {
    release(eye, {0, frame.stamp_ns, frame.token, false, frame.arrival_ns, false}, SyncLoss::uncertain, outcome);
    expire(other(eye), outcome);
    return;
  }
  const EyeClock::Reading reading = mine.clock.read(frame.stamp_ns, frame.arrival_ns);
  Waiting item{reading.index,    frame.stamp_ns,
               frame.token,      reading.verdict == EyeClock::Verdict::certain,
               frame.arrival_ns, reading.verdict != EyeClock::Verdict::uncertain};
  mine.counts.missing += reading.missing;
  if (reading.out_of_order) ++mine.counts.out_of_order;
  if (reading.restarted) {
    void_numbers(eye, outcome);
  }
  if (reading.verdict == EyeClock::Verdict::doubled) {
    release(eye, item, SyncLoss::doubled, outcome);
  } else if (pair_by_stamp(eye, item, outcome)) {
    // has gone out
  } else if (reading.verdict == EyeClock::Verdict::uncertain) {
    keep_unnumbered(eye, item, outcome);
  } else if (mine.any_paired && reading.index <= mine.last_paired) {
    release(eye, item, SyncLoss::late, outcome);
  } else {
    const auto at =
        std::find_if(mine.waiting.begin(), mine.waiting.end(), [&](const Waiting& w) { return w.index > item.index; });
    mine.waiting.insert(at, item);
  }
  if (reading.confirms) {
    for (Waiting& w : mine.waiting) w.certain = true;
  }
  relate(outcome);
  pair_up(outcome);
  expire(Eye::left, outcome);
  expire(Eye::right, outcome);
}

void PairSync::advance(std::int64_t now_ns, SyncOutcome& outcome) {
  if (!begun_) {  // both eyes have their time from here
    begun_ = true;
    for (Side& s : sides_) s.last_arrival_ns = now_ns;
  }
  for (const Eye eye : {Eye::left, Eye::right}) {
    Side& s = side(eye);
    if (s.lost || static_cast<double>(now_ns - s.last_arrival_ns) * 1e-9 <= options_.lost_after_s) continue;
    s.lost = true;
    release_all(eye, SyncLoss::unpaired, outcome);
    for (const Eye each : {Eye::left, Eye::right}) {
      for (const Waiting& frame : side(each).unnumbered) release(each, frame, SyncLoss::uncertain, outcome);
      side(each).unnumbered.clear();
    }
    expire(other(eye), outcome);
  }
}

SyncState PairSync::state() const {
  if (sides_[0].lost && sides_[1].lost) return SyncState::both_lost;
  if (sides_[0].lost) return SyncState::left_lost;
  if (sides_[1].lost) return SyncState::right_lost;
  if (!sides_[0].clock.locked() || !sides_[1].clock.locked()) return SyncState::acquiring;
  if (out_of_phase_) return SyncState::out_of_phase;
  return relation_ ? SyncState::synchronised : SyncState::acquiring;
}

std::optional<std::int64_t> PairSync::clock_offset_ns() const {
  if (!relation_) return std::nullopt;
  const EyeClock& l = sides_[0].clock;
  const EyeClock& r = sides_[1].clock;
  const double grids_ns = r.grid_ns(l.newest() + *relation_) - l.grid_ns(l.newest());
  return r.base_ns() - l.base_ns() + std::llround(grids_ns);
}

const char* sync_state_name(SyncState state) {
  switch (state) {
    case SyncState::acquiring:
      return "acquiring";
    case SyncState::synchronised:
      return "synchronised";
    case SyncState::out_of_phase:
      return "out of phase";
    case SyncState::left_lost:
      return "left eye lost";
    case SyncState::right_lost:
      return "right eye lost";
    case SyncState::both_lost:
      return "both eyes lost";
  }
  return "unknown";
}

}  // namespace cliquevo::drivers
