// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/dense_stereo.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stereo/block_matcher.h"
#include "stereo/prefilter.h"
#include "stereo/row_shares.h"
#include "stereo/smoothing.h"
#include "stereo/speckles.h"
#include "stereo/worker_pool.h"

namespace cliquevo::stereo {

namespace {

struct Bytes {
  const unsigned char* begin;
  const unsigned char* end;
};

template <typename T>
Bytes bytes(ImageView<T> v) {
  return {reinterpret_cast<const unsigned char*>(v.data),
          reinterpret_cast<const unsigned char*>(v.row(v.height - 1) + v.width)};
}

bool overlap(Bytes a, Bytes b) { return a.begin < b.end && b.begin < a.end; }

}  // namespace

struct DenseStereo::Impl {
  StereoParams params;
  int width = 0;
  int height = 0;
  const kernels::Table& kernel = kernels::active();
  MatchingPair pair;
  std::unique_ptr<WorkerPool> pool;
  std::optional<RowShares> shares;
  std::vector<StripMatcher> strips;  // one a worker, as the smoothers
  std::vector<Smoother> smoothers;
  SpeckleFilter speckles;
  Image<std::int16_t> matched;  // before speckles are removed and surfaces smoothed
  std::atomic<int> next_row{0};

  bool afterwards() const { return params.speckle_size > 0 || params.smoothing > 0; }
  void match(int worker, ImageView<const std::uint8_t> filtered, ImageView<std::int16_t> out);
  void clean_and_smooth(int worker, int begin, int end, ImageView<std::int16_t> out);
  // Calls work(worker, begin, end) for bands of rows; whoever is free takes the next one.
  template <typename Work>
  void share_bands(int band, const Work& work) {
    next_row.store(0);
    pool->run([&](int worker) {
      for (int begin = next_row.fetch_add(band); begin < height; begin = next_row.fetch_add(band)) {
        work(worker, begin, std::min(begin + band, height));
      }
    });
  }

  template <typename T>
  Result<void> check(ImageView<T> view, const char* name) const {
    if (view.data == nullptr) return Error{"cannot match", std::string(name) + " is null", "give a view of pixels"};
    if (!view.same_size(width, height)) {
      return Error{"cannot match",
                   std::string(name) + " is " + std::to_string(view.width) + "x" + std::to_string(view.height) + " px",
                   "give " + std::to_string(width) + "x" + std::to_string(height) + " px as at set-up"};
    }
    if (view.stride < view.width) {
      return Error{"cannot match", std::string(name) + " has rows closer than its width", "give the row's true stride"};
    }
    return {};
  }
};

void DenseStereo::Impl::match(int worker, ImageView<const std::uint8_t> filtered, ImageView<std::int16_t> out) {
  StripMatcher& strip = strips[static_cast<std::size_t>(worker)];
  const bool look_for_speckles = params.speckle_size > 0;
  if (look_for_speckles) speckles.start(worker);
  const int step = RowShares::step(worker);
  const int first = shares->first(worker);
  for (int y = first; shares->one_more(worker); y += step) {
    strip.match(kernel, params, pair, filtered, y, step, y == first, out);
    if (look_for_speckles) speckles.add_row(kernel, worker, out, y);
  }
  if (look_for_speckles) speckles.finish(worker);
}

void DenseStereo::Impl::clean_and_smooth(int worker, int begin, int end, ImageView<std::int16_t> out) {
  smoothers[static_cast<std::size_t>(worker)].smooth(
      kernel, matched.cview(), begin, end,
      [this](int y, std::int16_t* row) {
        if (params.speckle_size > 0) speckles.clean(y, params.speckle_size, row);
      },
      out);
}

DenseStereo::DenseStereo(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DenseStereo::DenseStereo(DenseStereo&&) noexcept = default;
DenseStereo& DenseStereo::operator=(DenseStereo&&) noexcept = default;
DenseStereo::~DenseStereo() = default;

const StereoParams& DenseStereo::params() const { return impl_->params; }
std::vector<std::thread::native_handle_type> DenseStereo::worker_handles() { return impl_->pool->handles(); }

Result<DenseStereo> DenseStereo::make(const StereoParams& params, int width, int height) {
  if (auto ok = params.check(); !ok) return ok.error();
  const std::string size = std::to_string(width) + "x" + std::to_string(height) + " px";
  if (width <= 0 || height <= 0 || width > 16384 || height > 16384) {
    return Error{"cannot set up stereo", size, "give an image of 1 to 16384 px each way"};
  }
  if (params.window > width || params.window_height > height) {
    return Error{"cannot set up stereo",
                 "window " + std::to_string(params.window) + "x" + std::to_string(params.window_height) +
                     " is larger than the image, " + size,
                 "give a smaller window or a larger image"};
  }
  if (params.min_disparity + params.num_disparities > width) {
    return Error{"cannot set up stereo",
                 "disparities up to " + std::to_string(params.min_disparity + params.num_disparities - 1) +
                     " reach beyond the image, " + size,
                 "give fewer disparities or a larger image"};
  }
  auto impl = std::make_unique<Impl>();
  impl->params = params;
  impl->width = width;
  impl->height = height;
  impl->pair.prepare(width, height);
  // A strip lower than the window would sum more rows to begin with than it then moves through.
  const int useful = std::clamp(height / params.window, 1, params.workers);
  impl->shares.emplace(useful, height);
  impl->strips.resize(static_cast<std::size_t>(useful));
  for (StripMatcher& strip : impl->strips) strip.prepare(params, width);
  impl->smoothers.resize(static_cast<std::size_t>(useful));
  for (Smoother& smoother : impl->smoothers) smoother.prepare(width, params.smoothing);
  if (params.speckle_size > 0) {
    impl->speckles.prepare(width, height, params.speckle_range * kDisparityScale, *impl->shares);
  }
  if (impl->afterwards()) impl->matched.resize(width, height);
  impl->pool = std::make_unique<WorkerPool>(useful);
  return DenseStereo(std::move(impl));
}

Result<void> DenseStereo::compute(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                                  ImageView<std::uint8_t> filtered_left, ImageView<std::int16_t> disparity) {
  Impl& s = *impl_;
  if (auto ok = s.check(left, "the left image"); !ok) return ok;
  if (auto ok = s.check(right, "the right image"); !ok) return ok;
  if (auto ok = s.check(filtered_left, "the filtered image"); !ok) return ok;
  if (auto ok = s.check(disparity, "the disparity image"); !ok) return ok;
  const Bytes out[] = {bytes(filtered_left), bytes(disparity)};
  for (const Bytes& o : out) {
    if (overlap(o, bytes(left)) || overlap(o, bytes(right))) {
      return Error{"cannot match", "an output view overlaps an input view", "give each image its own memory"};
    }
  }
  if (overlap(out[0], out[1])) {
    return Error{"cannot match", "the output views overlap", "give each image its own memory"};
  }
  constexpr int kBand = 16;        // rows; small, so that all end at about the same time
  constexpr int kSmoothBand = 32;  // the smoother begins anew at each, a few rows early
  s.share_bands(kBand, [&](int /*worker*/, int begin, int end) {
    prefilter_rows(s.kernel, s.params, left, right, begin, end, filtered_left, s.pair);
  });
  const ImageView<std::int16_t> matched = s.afterwards() ? s.matched.view() : disparity;
  s.shares->restart();
  s.pool->run([&](int worker) { s.match(worker, filtered_left, matched); });
  if (!s.afterwards()) return {};
  if (s.params.speckle_size > 0) s.speckles.join_seams(s.kernel, matched);
  s.share_bands(kSmoothBand,
                [&](int worker, int begin, int end) { s.clean_and_smooth(worker, begin, end, disparity); });
  return {};
}

}  // namespace cliquevo::stereo
