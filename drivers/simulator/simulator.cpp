// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "core/base/caught.h"
#include "drivers/simulator/board_source.h"
#include "drivers/simulator/camera_sets.h"
#include "drivers/simulator/course.h"
#include "drivers/simulator/fault.h"
#include "drivers/simulator/photograph.h"
#include "drivers/simulator/raw_pair.h"
#include "drivers/simulator/render_cache.h"
#include "drivers/simulator/renderer.h"
#include "drivers/simulator/rough_camera.h"
#include "drivers/simulator/world.h"

namespace cliquevo::drivers {

namespace {

using namespace sim;

// Renders ahead: worker k of the pool takes the next frame that nobody has taken; frames are independent of each other,
// so that their number and timing cannot change an image.
class RenderedSimulator : public Simulator {
 public:
  explicit RenderedSimulator(const SimulatorOptions& options)
      : options_(with_camera(options)),
        course_(options_),
        cache_(options_),
        same_every_frame_(course_.still() && options.movers == 0 && options.scene == "natural") {
    info_.width = options_.width;
    info_.height = options_.height;
    info_.rate_hz = options_.rate_hz / static_cast<double>(options_.every);
    info_.frame_count = (options_.frames + options_.every - 1) / options_.every;
    info_.description = fmt::format("simulator{}, {} course, {}world {}, noise {}", options_.raw ? " (raw)" : "",
                                    options_.course, options_.camera == "clean" ? "" : options_.camera + " camera, ",
                                    options_.world_seed, options_.noise_seed);
    info_.calibration = simulated_calibration(options_);
    info_.T_body_camera = course_.T_body_camera();
    T_first_world_ = course_.T_world_camera(0.0).inverse();
  }

  ~RenderedSimulator() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    for (std::thread& t : threads_) t.join();
  }

  const SourceInfo& info() const override { return info_; }

  Result<bool> next(StereoPair& pair) override {
    if (next_ >= info_.frame_count) return false;
    const std::int64_t frame = next_ * options_.every;
    if (threads_.empty()) start();
    if (same_every_frame_) {
      if (next_ == 0) produce(0, own_scratch_, still_);
      if (auto ok = deliver(frame, still_, pair); !ok) return ok.error();
    } else {
      Slot& slot = slots_[static_cast<std::size_t>(next_) % slots_.size()];
      {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [&] { return slot.holds == next_ || failure_; });
        if (slot.holds != next_) return *failure_;
      }
      if (auto ok = deliver(frame, slot.pair, pair); !ok) return ok.error();
      const std::lock_guard<std::mutex> lock(mutex_);
      slot.holds = -1;
      ++consumed_;
    }
    changed_.notify_all();
    ++next_;
    truth_of_ = -1;
    return true;
  }

  ImageView<const float> truth_disparity() const override {
    if (next_ == 0) return {};
    const std::int64_t frame = (next_ - 1) * options_.every;
    if (truth_of_ != frame) {
      renderer().disparity(frame, own_scratch_, truth_);
      truth_of_ = frame;
    }
    return truth_.view();
  }

  CameraShake truth_shake() const override {
    if (next_ == 0) return {};
    return shake_of(options_, delivered_frame(options_, (next_ - 1) * options_.every, 1));
  }

 private:
  struct Slot {
    std::int64_t holds = -1;  // position in the source
    CleanPair pair;
  };

  void start() {
    if (same_every_frame_) return;
    const unsigned cores = std::max(std::thread::hardware_concurrency(), 1U);
    const std::int64_t wanted = options_.workers > 0 ? options_.workers : static_cast<std::int64_t>(cores);
    const auto count = static_cast<std::size_t>(std::min(wanted, info_.frame_count));
    slots_.resize(count + 2);
    for (std::size_t k = 0; k < count; ++k) threads_.emplace_back([this] { work(); });
  }

  void work() {
    const auto done = guarded("simulator", [this] { return render_all(), Result<void>(); });
    if (done) return;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      failure_ = done.error();
    }
    changed_.notify_all();
  }

  void render_all() {
    RenderScratch scratch;
    for (;;) {
      std::int64_t mine = 0;
      {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [&] {
          return stop_ || taken_ >= info_.frame_count || taken_ < consumed_ + static_cast<std::int64_t>(slots_.size());
        });
        if (stop_ || taken_ >= info_.frame_count) return;
        mine = taken_++;
      }
      Slot& slot = slots_[static_cast<std::size_t>(mine) % slots_.size()];
      produce(mine * options_.every, scratch, slot.pair);
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        slot.holds = mine;
      }
      changed_.notify_all();
    }
  }

  void produce(std::int64_t frame, RenderScratch& scratch, CleanPair& pair) const {
    if (cache_.load(frame, pair)) return;
    renderer().render(frame, scratch, pair);
    cache_.store(frame, pair);
  }

  Result<void> deliver(std::int64_t frame, const CleanPair& clean, StereoPair& pair) const {
    pair.index = next_;
    pair.stamp_ns = stamp_of(options_, frame);
    pair.truth_T_world_camera =
        frame == 0 ? RigidTransform{} : T_first_world_ * course_.T_world_camera(static_cast<double>(frame));
    const std::int64_t right_frame = delivered_frame(options_, frame, 1);
    const bool hangs = right_frame != frame && !same_every_frame_;
    if (hangs && frozen_.right.empty()) produce(right_frame, own_scratch_, frozen_);
    const auto right = hangs ? frozen_.right.cview() : clean.right.cview();
    if (auto ok = photograph(options_, course_, frame, 0, clean.left.cview(), rough_, pair.left); !ok) return ok;
    return photograph(options_, course_, frame, 1, right, rough_, pair.right);
  }

  // The world is made when the first frame is not in the store.
  const Renderer& renderer() const {
    std::call_once(world_made_, [this] {
      world_ = std::make_unique<World>(options_, course_);
      renderer_ = std::make_unique<Renderer>(options_, course_, *world_);
    });
    return *renderer_;
  }

  const SimulatorOptions options_;
  const Course course_;
  const RenderCache cache_;
  const bool same_every_frame_;
  SourceInfo info_;
  RigidTransform T_first_world_;
  std::int64_t next_ = 0;

  mutable std::once_flag world_made_;
  mutable std::unique_ptr<World> world_;
  mutable std::unique_ptr<Renderer> renderer_;

  mutable RenderScratch own_scratch_;
  mutable RoughScratch rough_;
  CleanPair still_;
  mutable CleanPair frozen_;
  mutable Image<float> truth_;
  mutable std::int64_t truth_of_ = -1;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Slot> slots_;
  std::int64_t taken_ = 0;
  std::int64_t consumed_ = 0;
  bool stop_ = false;
  std::optional<Error> failure_;  // of a thread
  std::vector<std::thread> threads_;
};

}  // namespace

Result<std::unique_ptr<Simulator>> open_simulator(const SimulatorOptions& options) {
  if (const Result<void> checked = options.check(); !checked) return checked.error();
  if (!options.board.empty()) return open_board(with_camera(options));
  return std::unique_ptr<Simulator>(std::make_unique<RenderedSimulator>(options));
}

}  // namespace cliquevo::drivers
