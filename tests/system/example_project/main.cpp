// SPDX-License-Identifier: BSD-3-Clause
// Stereo and odometry in a program of one's own: a textured wall comes nearer by 10 cm.
#include <cmath>
#include <cstdio>

#include "core/vo/visual_odometry.h"
#include "stereo/dense_stereo.h"

using namespace cliquevo;

namespace {

// Smooth, aperiodic texture; x and y in m on the wall.
double grey(double x, double y) {
  return 128.0 + 40.0 * std::sin(23.0 * x + 5.0 * std::sin(7.1 * y)) +
         40.0 * std::sin(19.0 * y + 5.0 * std::sin(9.7 * x)) + 30.0 * std::sin(61.0 * x + 47.0 * y);
}

// The wall is slanted, so that no two columns see it at the same distance.
void see(const StereoModel& m, double camera_z, double camera_x, Image<std::uint8_t>& image) {
  image.resize(m.width, m.height);
  for (int v = 0; v < m.height; ++v) {
    for (int u = 0; u < m.width; ++u) {
      const double rx = (u - m.cx_px) / m.fx_px;
      const double ry = (v - m.cy_px) / m.fy_px;
      const double z = (3.0 + 0.3 * camera_x - camera_z) / (1.0 - 0.3 * rx);  // wall: Z = 3 + 0.3 X
      image.view()(u, v) = static_cast<std::uint8_t>(grey(camera_x + rx * z, ry * z));
    }
  }
}

void see(const StereoModel& m, double camera_z, Image<std::uint8_t>& left, Image<std::uint8_t>& right) {
  see(m, camera_z, 0.0, left);
  see(m, camera_z, m.baseline_m, right);
}

}  // namespace

int main() {
  StereoModel model;
  model.width = 320;
  model.height = 240;
  model.fx_px = model.fy_px = 300.0;
  model.cx_px = 159.5;
  model.cy_px = 119.5;
  model.baseline_m = 0.12;
  stereo::StereoParams params;
  params.num_disparities = 32;
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;

  // [ten lines]
  auto stereo = stereo::DenseStereo::make(params, model.width, model.height);
  auto odometry = vo::VisualOdometry::make(model, {});
  if (!stereo || !odometry) return 1;
  Image<std::uint8_t> filtered(model.width, model.height);
  Image<std::int16_t> disparity(model.width, model.height);
  for (int frame = 0; frame < 2; ++frame) {
    see(model, 0.1 * frame, left, right);  // your cameras: rectified, 8 bits
    if (!stereo->compute(left.cview(), right.cview(), filtered.view(), disparity.view())) return 1;
    if (!odometry->process({frame * 100'000'000, left.cview(), right.cview(), filtered.cview(), disparity.cview()}))
      return 1;
    const vo::Estimate& e = odometry->estimate();
    std::printf("%s %.4f m forward\n", vo::status_name(e.status), e.T_world_camera.t.z());
  }
  // [end]
  const vo::Estimate& e = odometry->estimate();
  return e.status == vo::Status::valid && std::abs(e.T_world_camera.t.z() - 0.1) < 0.005 ? 0 : 1;
}
