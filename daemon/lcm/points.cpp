// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/points.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "daemon/lcm/messages.h"

namespace cliquevo::daemon {

namespace {

constexpr double kSixteenths = 16.0;
constexpr double kMostSigma = 0.25;  // of the depth

// A pixel whose disparity is known. Ordered by disparity, then as they stand in the image: one order for all.
struct Known {
  std::uint16_t disparity;
  int x;
  int y;
  bool operator<(const Known& other) const {
    if (disparity != other.disparity) return disparity < other.disparity;
    return y != other.y ? y < other.y : x < other.x;
  }
};

void put_point(const Known& known, const TappedImages& images, const StereoModel& model,
               const RigidTransform& T_body_camera, points_t& out) {
  const double disparity_px = known.disparity / kSixteenths;
  // sigma / depth = kDisparitySigma_px / (disparity + doffs)
  if ((disparity_px + model.doffs_px) * kMostSigma < kDisparitySigma_px) return;
  const Eigen::Vector3d seen = model.triangulate(known.x, known.y, disparity_px);
  const Eigen::Vector3d point = T_body_camera * seen;
  const double along_ray = seen.norm() / seen.z();
  out.x.push_back(static_cast<float>(point.x()));
  out.y.push_back(static_cast<float>(point.y()));
  out.z.push_back(static_cast<float>(point.z()));
  out.sigma.push_back(static_cast<float>(along_ray * model.depth_error_m(seen.z(), kDisparitySigma_px)));
  out.grey.push_back(images.left.cview().row(known.y)[known.x]);
}

}  // namespace

void build_points(const TappedImages& images, const StereoModel& model, const RigidTransform& T_body_camera,
                  int step_px, points_t& out) {
  out.utime = floor_us(images.stamp_ns);
  for (int i = 0; i < 3; ++i) out.camera_position[i] = T_body_camera.t[i];
  out.step_px = step_px;
  for (auto* list : {&out.x, &out.y, &out.z, &out.sigma}) list->clear();
  out.grey.clear();
  const ImageView<const std::uint16_t> disparity = images.disparity.cview();
  std::vector<Known> square;
  square.reserve(static_cast<std::size_t>(step_px) * static_cast<std::size_t>(step_px));
  for (int top = 0; top < disparity.height; top += step_px) {
    const int bottom = std::min(top + step_px, disparity.height);
    for (int left = 0; left < disparity.width; left += step_px) {
      const int right = std::min(left + step_px, disparity.width);
      square.clear();
      for (int y = top; y < bottom; ++y) {
        const std::uint16_t* row = disparity.row(y);
        for (int x = left; x < right; ++x) {
          if (row[x] > 0) square.push_back({row[x], x, y});
        }
      }
      if (square.empty() || 2 * std::ssize(square) < std::ptrdiff_t{right - left} * (bottom - top)) continue;
      const auto median = square.begin() + std::ssize(square) / 2;
      std::nth_element(square.begin(), median, square.end());
      put_point(*median, images, model, T_body_camera, out);
    }
  }
  out.num_points = static_cast<std::int32_t>(out.x.size());
}

}  // namespace cliquevo::daemon
