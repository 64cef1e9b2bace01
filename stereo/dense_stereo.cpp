// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/dense_stereo.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "stereo/block_matcher.h"
#include "stereo/prefilter.h"
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
  std::vector<StripMatcher> strips;  // one a worker
  std::unique_ptr<WorkerPool> pool;
  SpeckleFilter speckles;
  Smoother smoother;

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

DenseStereo::DenseStereo(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DenseStereo::DenseStereo(DenseStereo&&) noexcept = default;
DenseStereo& DenseStereo::operator=(DenseStereo&&) noexcept = default;
DenseStereo::~DenseStereo() = default;

const StereoParams& DenseStereo::params() const { return impl_->params; }

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
  impl->strips.resize(static_cast<std::size_t>(useful));
  for (StripMatcher& strip : impl->strips) strip.prepare(params, width);
  impl->pool = std::make_unique<WorkerPool>(useful);
  impl->speckles.prepare(width, height);
  impl->smoother.prepare(width, params.smoothing);
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
  const int workers = s.pool->workers();
  const auto rows = [&](int worker) { return s.height * worker / workers; };  // first row of a worker's strip
  s.pool->run([&](int worker) {
    prefilter_rows(s.kernel, s.params, left, right, rows(worker), rows(worker + 1), filtered_left, s.pair);
  });
  s.pool->run([&](int worker) {
    s.strips[static_cast<std::size_t>(worker)].match(s.kernel, s.params, s.pair, filtered_left, rows(worker),
                                                     rows(worker + 1), disparity);
  });
  if (s.params.speckle_size > 0) {
    s.speckles.remove(s.kernel, disparity, s.params.speckle_size, s.params.speckle_range * kDisparityScale);
  }
  if (s.params.smoothing > 0) s.smoother.smooth(s.kernel, disparity);
  return {};
}

}  // namespace cliquevo::stereo
