// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/rectify.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "stereo/camera_projection.h"
#include "stereo/kernels/kernels.h"
#include "stereo/rectification.h"

namespace cliquevo::stereo {

namespace {

using kernels::RemapRow;
constexpr int kFraction = RemapRow::kFraction;

// Means of 2x2 pixels. out: half the size, rounded down.
void halve(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) {
  for (int y = 0; y < out.height; ++y) {
    const std::uint8_t* a = in.row(2 * y);
    const std::uint8_t* b = in.row(2 * y + 1);
    std::uint8_t* to = out.row(y);
    for (int x = 0; x < out.width; ++x) {
      to[x] = static_cast<std::uint8_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2) >> 2);
    }
  }
}

// A mask's pixel may be used where all its four may.
void halve_mask(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) {
  for (int y = 0; y < out.height; ++y) {
    const std::uint8_t* a = in.row(2 * y);
    const std::uint8_t* b = in.row(2 * y + 1);
    for (int x = 0; x < out.width; ++x) {
      out(x, y) = std::min({a[2 * x], a[2 * x + 1], b[2 * x], b[2 * x + 1]});
    }
  }
}

// How often the raw image is halved before it is resampled to pixels of this size.
int halvings_for(double raw_focal_px, double focal_px) {
  constexpr int kMost = 3;
  constexpr double kTwice = 2.0 - 1e-6;
  int halvings = 0;
  for (double ratio = raw_focal_px / focal_px; ratio >= kTwice && halvings < kMost; ratio *= 0.5) ++halvings;
  return halvings;
}

// The camera as its halved images show it.
CameraCalibration halved(CameraCalibration camera, int halvings) {
  for (int i = 0; i < halvings; ++i) {
    camera.width /= 2;
    camera.height /= 2;
    camera.fx_px *= 0.5;
    camera.fy_px *= 0.5;
    camera.cx_px = 0.5 * (camera.cx_px + 0.5) - 0.5;
    camera.cy_px = 0.5 * (camera.cy_px + 0.5) - 0.5;
  }
  return camera;
}

// Raw images of a rectified pair are those of pinholes.
CameraCalibration pinhole(const StereoModel& m, double doffs_px) {
  CameraCalibration out;
  out.width = m.width;
  out.height = m.height;
  out.fx_px = m.fx_px;
  out.fy_px = m.fy_px;
  out.cx_px = m.cx_px + doffs_px;
  out.cy_px = m.cy_px;
  return out;
}

}  // namespace

struct RectifierMap {
  int raw_width = 0;
  int raw_height = 0;
  int width = 0;
  // Model's size, row by row; see RemapRow.
  std::vector<std::int16_t> x, y;
  std::vector<std::uint8_t> weight_x, weight_y, at;
  std::vector<RemapRow::Patch> patches;  // of each row its full blocks

  void resize(int w, int h) {
    width = w;
    const auto n = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    x.assign(n, -1);
    y.assign(n, -1);
    for (auto* v : {&weight_x, &weight_y, &at}) v->assign(n, 0);
    patches.assign(static_cast<std::size_t>(w / RemapRow::kBlock) * static_cast<std::size_t>(h), {-1, -1});
  }
  RemapRow row(int v) const {
    const auto first = static_cast<std::size_t>(v) * static_cast<std::size_t>(width);
    return {x.data() + first,
            y.data() + first,
            weight_x.data() + first,
            weight_y.data() + first,
            patches.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(width / RemapRow::kBlock),
            at.data() + first};
  }
};

namespace {

// Where all sources of a block lie close together: the patch that holds them, and their places in it.
void find_patch(RectifierMap& map, std::size_t first, RemapRow::Patch& patch) {
  const auto x = map.x.begin() + static_cast<std::ptrdiff_t>(first);
  const auto y = map.y.begin() + static_cast<std::ptrdiff_t>(first);
  const auto [left, right] = std::minmax_element(x, x + RemapRow::kBlock);
  const auto [top, bottom] = std::minmax_element(y, y + RemapRow::kBlock);
  if (*left < 0 || *right + 1 - *left >= RemapRow::Patch::kWidth || *bottom + 1 - *top >= RemapRow::Patch::kHeight) {
    return;
  }
  if (map.raw_width < RemapRow::Patch::kWidth || map.raw_height < RemapRow::Patch::kHeight) return;
  patch.x = std::min(*left, static_cast<std::int16_t>(map.raw_width - RemapRow::Patch::kWidth));
  patch.y = std::min(*top, static_cast<std::int16_t>(map.raw_height - RemapRow::Patch::kHeight));
  for (int i = 0; i < RemapRow::kBlock; ++i) {
    map.at[first + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(x[i] - patch.x + 128 * (y[i] - patch.y));
  }
}

// Where each pixel of the rectified image comes from; the share of pixels that have a source.
double fill_map(const CameraCalibration& camera, const Eigen::Matrix3d& R, const StereoModel& model, double cx_px,
                RectifierMap& map) {
  const CameraProjection projection(camera);
  map.raw_width = camera.width;
  map.raw_height = camera.height;
  map.resize(model.width, model.height);
  std::size_t i = 0;
  std::size_t filled = 0;
  for (int v = 0; v < model.height; ++v) {
    for (int u = 0; u < model.width; ++u, ++i) {
      const Eigen::Vector3d ray((u - cx_px) / model.fx_px, (v - model.cy_px) / model.fy_px, 1.0);
      const auto p = projection.project(R.transpose() * ray);
      if (!p || !(p->x() >= 0.0 && p->y() >= 0.0 && p->x() <= camera.width - 1 && p->y() <= camera.height - 1)) {
        continue;
      }
      const int x = static_cast<int>(std::lround(p->x() * kFraction));
      const int y = static_cast<int>(std::lround(p->y() * kFraction));
      // The last pixel is its left neighbour plus a whole step, so that the right one may always be read.
      const int x0 = std::min(x / kFraction, camera.width - 2);
      const int y0 = std::min(y / kFraction, camera.height - 2);
      map.x[i] = static_cast<std::int16_t>(x0);
      map.y[i] = static_cast<std::int16_t>(y0);
      map.weight_x[i] = static_cast<std::uint8_t>(x - x0 * kFraction);
      map.weight_y[i] = static_cast<std::uint8_t>(y - y0 * kFraction);
      ++filled;
    }
  }
  const int blocks = model.width / RemapRow::kBlock;
  for (int v = 0; v < model.height; ++v) {
    for (int b = 0; b < blocks; ++b) {
      const auto row = static_cast<std::size_t>(v);
      const auto block = static_cast<std::size_t>(b);
      find_patch(map, row * static_cast<std::size_t>(model.width) + block * RemapRow::kBlock,
                 map.patches[row * static_cast<std::size_t>(blocks) + block]);
    }
  }
  return static_cast<double>(filled) / static_cast<double>(map.x.size());
}

// Of the rectified rows, which may be more or fewer of the scene than the raw ones.
double readout_s(const StereoCalibration& calibration, const StereoModel& model) {
  const bool as_given = calibration.rectified && calibration.prescribed;
  const double raw_height = as_given ? calibration.prescribed->model.height : calibration.left.height;
  const double raw_focal = as_given ? calibration.prescribed->model.fy_px : calibration.left.fy_px;
  return calibration.readout_s * (model.height / model.fy_px) / (raw_height / raw_focal);
}

}  // namespace

struct Rectifier::Impl {
  StereoModel model;
  bool identity = false;
  RectifierMap left, right;
  // Raw images' sizes, and memory for their halves; empty = they are taken as they are.
  int left_width = 0;
  int left_height = 0;
  int right_width = 0;
  int right_height = 0;
  mutable std::vector<Image<std::uint8_t>> left_halves, right_halves;
  const kernels::Table& kernel = kernels::active();

  const RectifierMap& map(CameraSide side) const { return side == CameraSide::left ? left : right; }
  void prepare(const CameraCalibration& l, const CameraCalibration& r) {
    left_width = l.width;
    left_height = l.height;
    right_width = r.width;
    right_height = r.height;
    const auto add = [](std::vector<Image<std::uint8_t>>& to, const CameraCalibration& camera, double focal_px) {
      const int count = halvings_for(0.5 * (camera.fx_px + camera.fy_px), focal_px);
      for (int i = 1; i <= count; ++i) to.emplace_back(camera.width >> i, camera.height >> i);
    };
    const double focal_px = 0.5 * (model.fx_px + model.fy_px);
    add(left_halves, l, focal_px);
    add(right_halves, r, focal_px);
  }
  // What the map resamples.
  template <typename Halve>
  ImageView<const std::uint8_t> source(CameraSide side, ImageView<const std::uint8_t> raw,
                                       const Halve& halve_once) const {
    for (Image<std::uint8_t>& half : side == CameraSide::left ? left_halves : right_halves) {
      halve_once(raw, half.view());
      raw = half.cview();
    }
    return raw;
  }
  Result<void> check(CameraSide side, ImageView<const std::uint8_t> raw, ImageView<std::uint8_t> out) const {
    const auto wrong = [](const char* where, int w, int h, int want_w, int want_h) {
      return Error{"cannot rectify", where,
                   "give an image of " + std::to_string(want_w) + "x" + std::to_string(want_h) + " px, not " +
                       std::to_string(w) + "x" + std::to_string(h)};
    };
    const int raw_width = identity ? model.width : side == CameraSide::left ? left_width : right_width;
    const int raw_height = identity ? model.height : side == CameraSide::left ? left_height : right_height;
    if (raw.empty() || !raw.same_size(raw_width, raw_height) || raw.stride < raw.width) {
      return wrong("raw image", raw.width, raw.height, raw_width, raw_height);
    }
    if (out.empty() || !out.same_size(model.width, model.height) || out.stride < out.width) {
      return wrong("rectified image", out.width, out.height, model.width, model.height);
    }
    return {};
  }
};

Rectifier::Rectifier(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Rectifier::Rectifier(Rectifier&&) noexcept = default;
Rectifier& Rectifier::operator=(Rectifier&&) noexcept = default;
Rectifier::~Rectifier() = default;

const StereoModel& Rectifier::model() const { return impl_->model; }
bool Rectifier::is_identity() const { return impl_->identity; }

Result<Rectifier> Rectifier::make(const StereoCalibration& calibration, const RectifyParams& params) {
  auto chosen = choose_rectification(calibration, params);
  if (!chosen) return chosen.error();
  auto impl = std::make_unique<Impl>();
  impl->model = chosen->model;
  impl->model.readout_s = readout_s(calibration, chosen->model);
  impl->identity = calibration.rectified && params.native();
  if (!impl->identity) {
    const StereoModel& m = impl->model;
    CameraCalibration left_camera = calibration.left;
    CameraCalibration right_camera = calibration.right;
    if (calibration.rectified) {
      const StereoModel& given = calibration.prescribed->model;
      left_camera = pinhole(given, 0.0);
      right_camera = pinhole(given, given.doffs_px);
      chosen->R_left = chosen->R_right = Eigen::Matrix3d::Identity();
    }
    impl->prepare(left_camera, right_camera);
    left_camera = halved(left_camera, static_cast<int>(impl->left_halves.size()));
    right_camera = halved(right_camera, static_cast<int>(impl->right_halves.size()));
    const double left = fill_map(left_camera, chosen->R_left, m, m.cx_px, impl->left);
    const double right = fill_map(right_camera, chosen->R_right, m, m.cx_px + m.doffs_px, impl->right);
    if (left < 0.25 || right < 0.25) {
      return Error{"cannot rectify with this calibration",
                   (calibration.source.empty() ? std::string() : calibration.source + ", ") +
                       "less than a quarter of the rectified image would show anything",
                   "calibrate the cameras again or name the right calibration file"};
    }
  }
  return Rectifier(std::move(impl));
}

Result<void> Rectifier::rectify(CameraSide side, ImageView<const std::uint8_t> raw, ImageView<std::uint8_t> out) const {
  if (auto ok = impl_->check(side, raw, out); !ok) return ok;
  if (impl_->identity) {
    for (int y = 0; y < out.height; ++y) std::memcpy(out.row(y), raw.row(y), static_cast<std::size_t>(out.width));
    return {};
  }
  const RectifierMap& map = impl_->map(side);
  const ImageView<const std::uint8_t> from = impl_->source(side, raw, halve);
  for (int y = 0; y < out.height; ++y) {
    impl_->kernel.remap_row(from.data, from.stride, map.row(y), out.width, out.row(y));
  }
  return {};
}

Result<void> Rectifier::rectify_mask(CameraSide side, ImageView<const std::uint8_t> raw,
                                     ImageView<std::uint8_t> out) const {
  if (auto ok = impl_->check(side, raw, out); !ok) return ok;
  if (impl_->identity) return rectify(side, raw, out);
  const ImageView<const std::uint8_t> from = impl_->source(side, raw, halve_mask);
  for (int y = 0; y < out.height; ++y) {
    const RemapRow map = impl_->map(side).row(y);
    for (int x = 0; x < out.width; ++x) {
      const bool seen = map.x[x] >= 0;
      out(x, y) =
          seen ? from(map.x[x] + (2 * map.weight_x[x] >= kFraction), map.y[x] + (2 * map.weight_y[x] >= kFraction)) : 0;
    }
  }
  return {};
}

}  // namespace cliquevo::stereo
