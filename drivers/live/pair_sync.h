// SPDX-License-Identifier: BSD-3-Clause
// Makes pairs of the frames of two live cameras: by exposure time, never by order of arrival. The offset and drift
// between their clocks are estimated. A pair is given as soon as it is certain; every frame is paired or counted.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"
#include "drivers/live/eye_clock.h"

namespace cliquevo::drivers {

enum class Eye { left, right };

struct PairSyncOptions {
  double rate_hz = 0.0;   // nominal, of both eyes; must be given
  bool triggered = true;  // both eyes expose at once (one trigger); false: each at its own pace
  // Stamps of both eyes are on one clock (PTP, or mapped to the host's): frames that arrive together need not wait
  // until the clocks are learnt.
  bool shared_clock = false;
  // Stamps are made by this host when a frame arrives: after a stall they are late by any amount. A frame is then taken
  // only behind others whose stamps advance as their sequence numbers do.
  bool stamped_on_arrival = false;
  double tolerance = 0.25;    // periods; largest difference of exposure where they are not triggered, or clock shared
  double lost_after_s = 1.0;  // without a frame an eye counts as lost

  Result<void> check() const;
};

// A frame's exposure on its camera's clock, its arrival on the host's monotonic clock, and what the caller knows it by.
struct SyncFrame {
  TimestampNs stamp_ns = 0;
  std::int64_t arrival_ns = 0;
  std::uint32_t token = 0;
  std::int64_t sequence = 0;  // the camera's count of exposures, as far as it goes; used where stamped on arrival
};

struct SyncPair {
  std::uint32_t left = 0;  // tokens
  std::uint32_t right = 0;
  TimestampNs stamp_ns = 0;  // the left eye's
  std::int64_t skew_ns = 0;  // right exposure - left exposure, on one clock as far as it is known
};

// Why a frame is handed back without a partner.
enum class SyncLoss {
  unpaired,   // its partner did not come
  late,       // a later pair had gone out
  doubled,    // it was here before
  uncertain,  // the clock was not (or no more) known well enough
};

struct SyncReleased {
  Eye eye = Eye::left;
  std::uint32_t token = 0;
  SyncLoss why = SyncLoss::unpaired;
};

// What a call leads to. The caller keeps one and hands it in again: after the first calls nothing is allocated.
struct SyncOutcome {
  std::vector<SyncPair> pairs;
  std::vector<SyncReleased> released;
  void clear() { pairs.clear(), released.clear(); }
};

// Of one eye. received = paired + unpaired + late + doubled + uncertain + waiting(), at any time.
struct SyncCounts {
  std::int64_t received = 0;
  std::int64_t paired = 0;
  std::int64_t unpaired = 0;
  std::int64_t late = 0;
  std::int64_t doubled = 0;
  std::int64_t uncertain = 0;
  // Seen on the way; they overlap with the above.
  std::int64_t missing = 0;       // numbers that did not come
  std::int64_t out_of_order = 0;  // came after a later one
  std::int64_t clock_steps = 0;   // times the clock had to be learnt again
};

enum class SyncState {
  acquiring,     // learning the clocks: nothing goes out
  synchronised,  // pairs go out
  out_of_phase,  // the eyes do not expose together
  left_lost,
  right_lost,
  both_lost,
};

class PairSync {
 public:
  explicit PairSync(const PairSyncOptions& options);

  // A frame arrived. Appends to `outcome`; tokens in it are the caller's again.
  void push(Eye eye, const SyncFrame& frame, SyncOutcome& outcome);
  // Time has passed without frames: notices lost eyes, hands back what waits for them.
  void advance(std::int64_t now_ns, SyncOutcome& outcome);

  SyncState state() const;
  const SyncCounts& counts(Eye eye) const { return side(eye).counts; }
  std::int64_t waiting(Eye eye) const {
    return static_cast<std::int64_t>(side(eye).waiting.size() + side(eye).unnumbered.size());
  }
  // Right stamp - left stamp of one exposure, ns; nothing before the clocks are known.
  std::optional<std::int64_t> clock_offset_ns() const;
  // Rate of the right clock against the left, parts per million; nothing before it is known to a few (1000 pairs).
  std::optional<double> clock_drift_ppm() const { return drift_ppm_; }

 private:
  struct Waiting {
    std::int64_t index = 0;
    TimestampNs stamp_ns = 0;
    std::uint32_t token = 0;
    bool certain = false;
    std::int64_t arrival_ns = 0;
    bool numbered = true;
  };
  struct Side {
    explicit Side(double period_ns) : clock(period_ns) {}
    EyeClock clock;
    SyncCounts counts;
    std::vector<Waiting> waiting;     // in order of their numbers
    std::vector<Waiting> unnumbered;  // of a shared clock: in order of arrival, few
    std::int64_t last_paired = 0;
    bool any_paired = false;  // since this eye's numbers began
    std::int64_t last_arrival_ns = 0;
    bool lost = false;
    TimestampNs last_stamp_ns = 0;  // of any frame, as is its number
    std::int64_t last_sequence = 0;
    int regular = -1;  // frames in a row whose stamp and sequence agree; -1: none at all yet
  };

  Side& side(Eye eye) { return sides_[static_cast<std::size_t>(eye)]; }
  const Side& side(Eye eye) const { return sides_[static_cast<std::size_t>(eye)]; }
  bool is_regular(Side& s, const SyncFrame& frame) const;
  void release(Eye eye, const Waiting& frame, SyncLoss why, SyncOutcome& outcome);
  void release_all(Eye eye, SyncLoss why, SyncOutcome& outcome);
  void release_below(Eye eye, std::int64_t index, SyncOutcome& outcome);
  void forget_relation();
  void void_numbers(Eye eye, SyncOutcome& outcome);
  bool pair_by_stamp(Eye eye, const Waiting& frame, SyncOutcome& outcome);
  void keep_unnumbered(Eye eye, const Waiting& frame, SyncOutcome& outcome);
  void take_out(Eye eye, const Waiting& frame, SyncOutcome& outcome);
  void relate(SyncOutcome& outcome);
  double difference_ns(std::int64_t left_index, std::int64_t right_index) const;
  void pair_up(SyncOutcome& outcome);
  void emit(const Waiting& left, const Waiting& right, SyncOutcome& outcome);
  void follow_drift(std::int64_t left_index);
  void expire(Eye eye, SyncOutcome& outcome);

  PairSyncOptions options_;
  double period_ns_;
  std::array<Side, 2> sides_;
  std::optional<std::int64_t> relation_;  // right number - left number of one exposure
  bool begun_ = false;
  bool out_of_phase_ = false;
  int trust_ = 0;                             // in stamps alone: below 0 there is none
  std::optional<TimestampNs> last_stamp_ns_;  // left one of the last pair, on a shared clock
  std::int64_t drift_index_ = 0;              // left number and offset that the drift is measured from
  double drift_offset_ns_ = 0.0;
  bool drift_begun_ = false;
  std::optional<double> drift_ppm_;
};

const char* sync_state_name(SyncState state);

}  // namespace cliquevo::drivers
