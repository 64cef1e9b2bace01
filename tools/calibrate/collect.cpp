// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/collect.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "tools/calibrate/detector.h"
#include "tools/calibrate/moved.h"
#include "tools/progress.h"
#include "tools/skipped_pairs.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

using calibration::View;

constexpr int kMostGuesses = 5;       // pairs in which something else is looked for
constexpr double kMostSkew_px = 0.1;  // by motion between the exposures of both cameras
constexpr std::size_t kMostMoving = 600;
constexpr std::size_t kFewViews = 12;

class Collector {
 public:
  Collector(const calibration::Board& board, const CollectOptions& options, int width)
      : detector_(board), options_(options), news_px_(options.news_of_width * width) {}

  void add(const drivers::StereoPair& pair, Collected& out) {
    ++out.pairs;
    View view;
    view.name = fmt::format("pair {}", pair.index);
    view.left = detector_.find_roughly(pair.left.cview());
    view.right = detector_.find_roughly(pair.right.cview());
    if (view.left.empty() && view.right.empty()) {
      ++out.without;
      last_.reset();
      guess(pair, out);
      return;
    }
    const double speed_px_s = speed_of(view, pair.stamp_ns);
    last_ = view;
    last_ns_ = pair.stamp_ns;
    const double skewed_px = speed_px_s * 1e-9 * static_cast<double>(std::abs(pair.right_offset_ns));
    if (options_.most_speed_px_s > 0.0 && (speed_px_s > options_.most_speed_px_s || skewed_px > kMostSkew_px)) {
      ++out.moving;
      moving_.push_back({speed_px_s, refined(pair, std::move(view))});
      if (moving_.size() > kMostMoving) slowest_first(kMostMoving / 2);
    } else if (is_known(view, out.views)) {
      ++out.alike;
    } else {
      out.views.push_back(refined(pair, std::move(view)));
    }
  }

  // Where a board was hardly ever held still, the slowest views have to do.
  void fill_up(Collected& out) {
    slowest_first(moving_.size());
    for (Moving& moving : moving_) {
      if (out.views.size() >= kFewViews) return;
      if (!std::isfinite(moving.speed_px_s) || is_known(moving.view, out.views)) continue;
      out.views.push_back(std::move(moving.view));
      --out.moving;
    }
  }

 private:
  View refined(const drivers::StereoPair& pair, View view) const {
    detector_.refine(pair.left.cview(), view.left);
    detector_.refine(pair.right.cview(), view.right);
    return view;
  }

  void guess(const drivers::StereoPair& pair, Collected& out) {
    if (guesses_ >= kMostGuesses || !out.guess.empty() || !out.views.empty()) return;
    ++guesses_;
    out.guess = detector_.nearest_guess(pair.left.cview());
  }

  // Of a board that was not seen just before: infinite.
  double speed_of(const View& view, TimestampNs stamp_ns) const {
    constexpr double kUnknown = std::numeric_limits<double>::infinity();
    const double since_s = 1e-9 * static_cast<double>(stamp_ns - last_ns_);
    if (!last_ || !(since_s > 0.0)) return kUnknown;
    const auto left = moved_px(last_->left, view.left), right = moved_px(last_->right, view.right);
    if (!left && !right) return kUnknown;
    return std::max(left.value_or(0.0), right.value_or(0.0)) / since_s;
  }

  void slowest_first(std::size_t most) {
    std::stable_sort(moving_.begin(), moving_.end(),
                     [](const Moving& a, const Moving& b) { return a.speed_px_s < b.speed_px_s; });
    moving_.resize(std::min(moving_.size(), most));
  }

  bool is_known(const View& view, const std::vector<View>& views) const {
    return std::any_of(views.begin(), views.end(), [&](const View& other) {
      const auto left = moved_px(other.left, view.left);
      const auto right = moved_px(other.right, view.right);
      return left && *left < news_px_ && (!right || *right < news_px_);
    });
  }

  BoardDetector detector_;
  CollectOptions options_;
  double news_px_;
  struct Moving {
    double speed_px_s = 0.0;
    View view;
  };
  std::vector<Moving> moving_;
  std::optional<View> last_;
  TimestampNs last_ns_ = 0;
  int guesses_ = 0;
};

}  // namespace

Result<Collected> collect_views(drivers::FrameSource& source, const calibration::Board& board,
                                const CollectOptions& options) {
  const drivers::SourceInfo& info = source.info();
  Collector collector(board, options, info.width);
  Collected out;
  Progress progress(info.frame_count);
  SkippedPairs skipped;
  drivers::StereoPair pair;
  const std::int64_t most_skipped = std::max<std::int64_t>(1000, info.frame_count);
  while (!StopOnSignal::received() && static_cast<std::int64_t>(out.views.size()) < options.most_views) {
    const auto more = source.next(pair);
    if (!more) {
      skipped.add(pair.index, more.error());
      if (info.live || skipped.count() > most_skipped) return more.error();
      continue;
    }
    if (!*more) break;
    collector.add(pair, out);
    progress.update(out.pairs, 0.0, fmt::format("{} views", out.views.size()));
  }
  progress.finish();
  collector.fill_up(out);
  out.stopped = StopOnSignal::received();
  return out;
}

}  // namespace cliquevo::tools
