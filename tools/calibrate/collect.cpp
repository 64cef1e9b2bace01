// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/collect.h"

#include <algorithm>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "tools/calibrate/detector.h"
#include "tools/progress.h"
#include "tools/skipped_pairs.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

using calibration::SeenCorner;
using calibration::Side;
using calibration::View;

constexpr int kGuesses = 5;  // pairs in which something else is looked for

// Mean distance of the corners that both have; none where they share fewer than half.
std::optional<double> moved_px(const std::vector<SeenCorner>& a, const std::vector<SeenCorner>& b) {
  std::map<int, Eigen::Vector2d> places;
  for (const SeenCorner& c : a) places[c.id] = c.px;
  double sum = 0.0;
  double shared = 0.0;
  for (const SeenCorner& c : b) {
    const auto at = places.find(c.id);
    if (at == places.end()) continue;
    sum += (c.px - at->second).norm();
    shared += 1.0;
  }
  if (shared < 0.5 * static_cast<double>(std::max(a.size(), b.size())) || shared < 1.0) return std::nullopt;
  return sum / shared;
}

class Collector {
 public:
  Collector(const calibration::Board& board, const CollectOptions& options, int width)
      : detector_(board), options_(options), news_px_(options.news_of_width * width) {}

  void add(const drivers::StereoPair& pair, Collected& out) {
    ++out.pairs;
    View view;
    view.name = fmt::format("pair {}", pair.index);
    view.left = detector_.find(pair.left.cview());
    view.right = detector_.find(pair.right.cview());
    if (view.left.empty() && view.right.empty()) {
      ++out.without;
      last_.reset();
      guess(pair, out);
      return;
    }
    const bool moves = options_.most_motion_px > 0.0 && is_moving(view);
    last_ = view;
    if (moves) {
      ++out.moving;
    } else if (is_known(view, out.views)) {
      ++out.alike;
    } else {
      out.views.push_back(std::move(view));
    }
  }

 private:
  void guess(const drivers::StereoPair& pair, Collected& out) {
    if (guesses_ >= kGuesses || !out.guess.empty() || !out.views.empty()) return;
    ++guesses_;
    out.guess = detector_.nearest_guess(pair.left.cview());
  }

  // A board that was not seen just before may have moved.
  bool is_moving(const View& view) const {
    if (!last_) return true;
    for (const Side side : {Side::left, Side::right}) {
      const auto moved = moved_px(last_->of(side), view.of(side));
      if (moved && *moved > options_.most_motion_px) return true;
    }
    return false;
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
  std::optional<View> last_;
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
  while (!StopOnSignal::asked() && static_cast<std::int64_t>(out.views.size()) < options.most_views) {
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
  out.stopped = StopOnSignal::asked();
  return out;
}

}  // namespace cliquevo::tools
