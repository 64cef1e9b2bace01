// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/capture.h"

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <optional>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "tools/calibrate/detector.h"
#include "tools/calibrate/moved.h"
#include "tools/calibrate/sharpness.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

using calibration::Side;

constexpr int kGuesses = 5;         // pairs in which something else is looked for
constexpr int kMostSkipped = 1000;  // pairs in a row that cannot be read
constexpr double kLongAgo_s = 2.0;  // a board seen so long ago gives no speed

}  // namespace

// Of a live source a thread of its own takes every pair, so that the newest is always there.
class Capture::Pairs {
 public:
  explicit Pairs(drivers::FrameSource& source) : source_(source) {
    if (source.info().live) thread_ = std::thread([this] { grab(); });
  }
  ~Pairs() {
    stop_ = true;
    source_.interrupt();
    if (thread_.joinable()) thread_.join();
  }

  enum class Got { pair, nothing_yet, end };
  Result<Got> next(drivers::StereoPair& pair) {
    if (!thread_.joinable()) return read(pair);
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::milliseconds(100), [this] { return fresh_ || ended_; });
    if (fresh_) {
      std::swap(pair, latest_);
      fresh_ = false;
      return Got::pair;
    }
    if (failure_) return *failure_;
    return ended_ ? Got::end : Got::nothing_yet;
  }

 private:
  Result<Got> read(drivers::StereoPair& pair) {
    const auto more = source_.next(pair);
    if (!more) return ++skipped_ > kMostSkipped ? Result<Got>(more.error()) : Result<Got>(Got::nothing_yet);
    skipped_ = 0;
    return *more ? Got::pair : Got::end;
  }

  void grab() {
    drivers::StereoPair pair;
    while (!stop_) {
      const auto got = read(pair);
      const std::lock_guard lock(mutex_);
      if (!got) failure_ = got.error();
      ended_ = !got || *got == Got::end;
      if (got && *got == Got::pair) {
        std::swap(pair, latest_);
        fresh_ = true;
      }
      changed_.notify_one();
      if (ended_) return;
    }
  }

  drivers::FrameSource& source_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  drivers::StereoPair latest_;
  bool fresh_ = false, ended_ = false;
  std::optional<Error> failure_;
  int skipped_ = 0;
  std::thread thread_;
};

// The guide in the terminal: a line that is written over; elsewhere one whenever it says something new.
class Capture::Lines {
 public:
  void show(const Guide& guide, const std::string& advice) {
    if (!terminal_) {
      if (advice == said_ && guide.views().size() == views_) return;
      std::fputs(fmt::format("{} views; {}\n", guide.views().size(), advice).c_str(), stderr);
    } else {
      std::string bars;
      for (const Bar& bar : guide.bars()) {
        static constexpr const char* kLevels[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
        bars += fmt::format(" {} {}", bar.name, kLevels[static_cast<int>(7.0 * bar.share)]);
      }
      std::fputs(fmt::format("\r{} views {}  {}\033[K", guide.views().size(), bars, printable(advice)).c_str(), stderr);
    }
    std::fflush(stderr);
    said_ = advice;
    views_ = guide.views().size();
  }
  void end() {
    if (terminal_ && !said_.empty()) std::fputs("\n", stderr);
    said_.clear();
  }

 private:
  const bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  std::string said_;
  std::size_t views_ = 0;
};

struct Capture::BoardFinder {
  explicit BoardFinder(const calibration::Board& board) : detector(board) {}

  Look look(const drivers::StereoPair& pair) {
    Look out;
    out.view.name = fmt::format("pair {}", pair.index);
    out.skew_s = 1e-9 * static_cast<double>(pair.right_offset_ns);
    for (const Side side : {Side::left, Side::right}) {
      const auto image = (side == Side::left ? pair.left : pair.right).cview();
      out.view.of(side) = detector.find_roughly(image);
      out.edge_px[static_cast<std::size_t>(side)] = edge_width_px(image, out.view.of(side));
    }
    const double since_s = 1e-9 * static_cast<double>(pair.stamp_ns - last_ns);
    if (last && since_s > 0.0 && since_s < kLongAgo_s) {
      for (const Side side : {Side::left, Side::right}) {
        const auto moved = moved_px(last->of(side), out.view.of(side));
        if (moved) out.speed_px_s = std::max(out.speed_px_s.value_or(0.0), *moved / since_s);
      }
    }
    last = out.view;
    last_ns = pair.stamp_ns;
    return out;
  }

  // As exactly as the pair shows it.
  calibration::View refined(const drivers::StereoPair& pair, calibration::View view) const {
    for (const Side side : {Side::left, Side::right}) {
      detector.refine((side == Side::left ? pair.left : pair.right).cview(), view.of(side));
    }
    return view;
  }

  BoardDetector detector;
  std::optional<calibration::View> last;
  TimestampNs last_ns = 0;
  int guesses = 0;
};

Capture::Capture(drivers::FrameSource& source, const calibration::Board& board, const GuideOptions& options,
                 CapturePage* page)
    : board_(board),
      guide_(board, source.info().width, source.info().height, options),
      page_(page),
      finder_(std::make_unique<BoardFinder>(board)),
      pairs_(std::make_unique<Pairs>(source)),
      lines_(std::make_unique<Lines>()) {}
Capture::~Capture() = default;

void Capture::look_at(const drivers::StereoPair& pair) {
  ++out_.pairs;
  const Look look = finder_->look(pair);
  Refusal refusal = guide_.judge(look);
  const bool wanted = page_ != nullptr && page_->take_wanted() && refusal != Refusal::no_board;
  if (page_ != nullptr && page_->drop_wanted()) guide_.drop_last();
  if (refusal == Refusal::none || wanted) {
    guide_.take(finder_->refined(pair, look.view));
    refusal = Refusal::none;
  } else if (refusal == Refusal::no_board) {
    ++out_.without;
    if (guide_.views().empty() && out_.guess.empty() && finder_->guesses++ < kGuesses) {
      out_.guess = finder_->detector.nearest_guess(pair.left.cview());
    }
  } else {
    if (guide_.improves_last(look, refusal)) guide_.improve_last(finder_->refined(pair, look.view));
    ++(refusal == Refusal::alike ? out_.alike : out_.moving);
  }
  if (page_ != nullptr) page_->show(pair, look, refusal, guide_);
  lines_->show(guide_, guide_.advice(look, refusal));
}

Result<Collected> Capture::collect() {
  drivers::StereoPair pair;
  while (!StopOnSignal::received() && !guide_.enough() && !(page_ != nullptr && page_->finish_wanted())) {
    const auto got = pairs_->next(pair);
    if (!got) {
      lines_->end();
      return got.error();
    }
    out_.ended = *got == Pairs::Got::end;
    if (out_.ended) break;
    if (*got == Pairs::Got::pair) look_at(pair);
  }
  lines_->end();
  out_.stopped = StopOnSignal::received();
  out_.enough = guide_.enough();
  Collected out = out_;
  out.views = guide_.views();
  return out;
}

}  // namespace cliquevo::tools
