// SPDX-License-Identifier: BSD-3-Clause
// The truth against the pictures: what the true depth and motion predict must be what the images show. A shift that the
// truth leaves over is estimated from the intensities (one step of Lucas-Kanade over a whole band of the image), so
// that hundredths of a pixel show.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/simulator.h"
#include "drivers/simulator/course.h"
#include "drivers/simulator/renderer.h"
#include "drivers/simulator/world.h"

namespace cliquevo::drivers {
namespace {

struct Rendered {
  sim::CleanPair pair;
  Image<float> disparity;
  RigidTransform T_world_camera;
};

class Scene {
 public:
  explicit Scene(const std::string& options)
      : options_(*parse_simulator_options(options)),
        course_(options_),
        world_(options_, course_),
        renderer_(options_, course_, world_) {}

  Rendered frame(std::int64_t n) {
    Rendered r;
    renderer_.render(n, scratch_, r.pair);
    renderer_.disparity(n, scratch_, r.disparity);
    r.T_world_camera = course_.T_world_camera(static_cast<double>(n));
    return r;
  }
  StereoModel model() const {
    StereoModel m;
    m.width = options_.width;
    m.height = options_.height;
    m.fx_px = m.fy_px = options_.focal_px;
    m.cx_px = 0.5 * (m.width - 1);
    m.cy_px = 0.5 * (m.height - 1);
    m.baseline_m = options_.baseline_m;
    return m;
  }

 private:
  SimulatorOptions options_;
  sim::Course course_;
  sim::World world_;
  sim::Renderer renderer_;
  sim::RenderScratch scratch_;
};

// Catmull-Rom; grey levels.
struct Sampler {
  ImageView<const std::uint16_t> image;
  static std::array<double, 4> weights(double t) {
    return {0.5 * (-t + 2 * t * t - t * t * t), 0.5 * (2 - 5 * t * t + 3 * t * t * t),
            0.5 * (t + 4 * t * t - 3 * t * t * t), 0.5 * (t * t * t - t * t)};
  }
  bool inside(double u, double v) const { return u >= 2.0 && v >= 2.0 && u < image.width - 3 && v < image.height - 3; }
  double operator()(double u, double v) const {
    const int i = static_cast<int>(u);
    const int j = static_cast<int>(v);
    const auto wu = weights(u - i);
    const auto wv = weights(v - j);
    double sum = 0.0;
    for (int b = 0; b < 4; ++b)
      for (int a = 0; a < 4; ++a) sum += wv[b] * wu[a] * image(i + a - 1, j + b - 1);
    return sum / sim::kGreyScale;
  }
};

struct Left {
  double du = 0.0, dv = 0.0;  // px that the truth leaves over
  double rms = 0.0;           // grey levels
  double gradient = 0.0;      // grey levels a px
  int count = 0;
};

// Compares image(u0, v0) with sampler(u, v) over the matches given.
struct Match {
  int u0, v0;
  double u, v;
};
Left compare(ImageView<const std::uint16_t> image, const Sampler& sampler, const std::vector<Match>& matches) {
  double a = 0, b = 0, c = 0, x = 0, y = 0, squares = 0, gradients = 0;
  Left left;
  for (const Match& m : matches) {
    if (!sampler.inside(m.u, m.v)) continue;
    const double gu = 0.5 * (sampler(m.u + 1.0, m.v) - sampler(m.u - 1.0, m.v));
    const double gv = 0.5 * (sampler(m.u, m.v + 1.0) - sampler(m.u, m.v - 1.0));
    const double r = image(m.u0, m.v0) / static_cast<double>(sim::kGreyScale) - sampler(m.u, m.v);
    if (std::abs(r) > 30.0) continue;  // covered in one of the two
    a += gu * gu;
    b += gu * gv;
    c += gv * gv;
    x += gu * r;
    y += gv * r;
    squares += r * r;
    gradients += gu * gu + gv * gv;
    ++left.count;
  }
  const double det = a * c - b * b;
  left.du = (c * x - b * y) / det;
  left.dv = (a * y - b * x) / det;
  left.rms = std::sqrt(squares / left.count);
  left.gradient = std::sqrt(gradients / left.count);
  return left;
}

std::string text(const Left& l) {
  return "left over " + std::to_string(l.du) + " " + std::to_string(l.dv) + " px, rms " + std::to_string(l.rms) +
         " grey, gradient " + std::to_string(l.gradient) + ", n " + std::to_string(l.count);
}

// No edge of a solid within two pixels: there a pixel shows a mixture of two depths.
bool smooth_around(ImageView<const float> disparity, int u, int v) {
  const float d = disparity(u, v);
  for (int b = -2; b <= 2; ++b) {
    for (int a = -2; a <= 2; ++a) {
      if (!disparity.contains(u + a, v + b) || !(std::abs(disparity(u + a, v + b) - d) < 0.03F * d + 0.2F))
        return false;
    }
  }
  return true;
}

// Bands by depth: near ground, middle, far.
constexpr double kBands[4] = {0.0, 2.5, 6.0, 25.0};

enum Direction { to_right_camera, to_next_frame };

// What is left over in a band, mean of some pairs of frames along the course.
Left left_over(Scene& scene, Direction direction, int band, const std::vector<std::int64_t>& frames) {
  const StereoModel model = scene.model();
  Left mean;
  for (const std::int64_t n : frames) {
    const Rendered a = scene.frame(n);
    const Rendered b = direction == to_next_frame ? scene.frame(n + 1) : Rendered{};
    const RigidTransform T_b_a =
        direction == to_next_frame ? b.T_world_camera.inverse() * a.T_world_camera : RigidTransform{};
    std::vector<Match> matches;
    for (int v = 0; v < model.height; ++v) {
      for (int u = 0; u < model.width; ++u) {
        const double d = static_cast<double>(a.disparity.view()(u, v));
        if (!std::isfinite(d) || !smooth_around(a.disparity.view(), u, v)) continue;
        const Eigen::Vector3d p = model.triangulate(u, v, d);
        if (p.z() < kBands[band] || p.z() >= kBands[band + 1]) continue;
        if (direction == to_right_camera) {
          matches.push_back({u, v, u - d, static_cast<double>(v)});
        } else {
          const Eigen::Vector3d q = T_b_a * p;
          matches.push_back(
              {u, v, model.fx_px * q.x() / q.z() + model.cx_px, model.fy_px * q.y() / q.z() + model.cy_px});
        }
      }
    }
    const Left l =
        compare(a.pair.left.view(), {(direction == to_right_camera ? a.pair.right : b.pair.left).view()}, matches);
    const double share = 1.0 / static_cast<double>(frames.size());
    mean.du += share * l.du;
    mean.dv += share * l.dv;
    mean.rms += share * l.rms;
    mean.gradient += share * l.gradient;
    mean.count += l.count;
  }
  testing::Test::RecordProperty("band_" + std::to_string(band), text(mean));
  return mean;
}

// On bare ground: at the edges of stones a pixel shows a mixture of depths, which shifts the estimate where there are
// many of them.
class SimulatorTruth : public testing::TestWithParam<const char*> {};

TEST_P(SimulatorTruth, DisparityIsWhatTheRightImageShows) {
  Scene scene(std::string("rocks=0,cache_dir=none,course=") + GetParam());
  for (int band = 0; band < 3; ++band) {
    const Left l = left_over(scene, to_right_camera, band, {0, 37});
    ASSERT_GT(l.count, 30000);
    EXPECT_LT(std::abs(l.du), 0.004) << text(l);
    EXPECT_LT(std::abs(l.dv), 0.002) << text(l);
    EXPECT_LT(l.rms, 0.12 * l.gradient) << text(l);
  }
}

TEST_P(SimulatorTruth, PoseIsWhatTheNextImageShows) {
  // Cubic interpolation is not exact and shifts by up to a hundredth; over some frames that averages out.
  constexpr double kTolerance[3] = {0.004, 0.006, 0.03};
  Scene scene(std::string("rocks=0,cache_dir=none,course=") + GetParam());
  for (int band = 0; band < 3; ++band) {
    const Left l = left_over(scene, to_next_frame, band, {0, 9, 18, 37});
    ASSERT_GT(l.count, 60000);
    EXPECT_LT(std::abs(l.du), kTolerance[band]) << text(l);
    EXPECT_LT(std::abs(l.dv), kTolerance[band]) << text(l);
    EXPECT_LT(l.rms, 0.4 * l.gradient) << text(l);
  }
}

INSTANTIATE_TEST_SUITE_P(Courses, SimulatorTruth, testing::Values("wheeled", "walking"),
                         [](const auto& i) { return std::string(i.param); });

TEST(SimulatorTruthWithRocks, NearSurfacesAreWhereTheDisparitySays) {
  Scene scene("cache_dir=none");
  for (int band = 0; band < 2; ++band) {
    const Left l = left_over(scene, to_right_camera, band, {0, 37});
    EXPECT_LT(std::abs(l.du), 0.006) << text(l);
    EXPECT_LT(std::abs(l.dv), 0.004) << text(l);
  }
}

// The raw pixel of a direction in the rectified frame, as OpenCV's pinhole model has it.
Eigen::Vector2d project_raw(const CameraCalibration& c, const Eigen::Matrix3d& R_rectified_raw,
                            const Eigen::Vector3d& ray) {
  const Eigen::Vector3d q = R_rectified_raw.transpose() * ray;
  const double x = q.x() / q.z();
  const double y = q.y() / q.z();
  const double r2 = x * x + y * y;
  const auto& k = c.coefficients;
  const double radial = 1.0 + k[0] * r2 + k[1] * r2 * r2;
  return {c.fx_px * (x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x)) + c.cx_px,
          c.fy_px * (y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y) + c.cy_px};
}

TEST(SimulatorTruthOfTheRawPair, RectifiedByItsCalibrationItShowsTheDisparity) {
  const char* options = "raw=on,rocks=0,cache_dir=none";
  Scene scene(options);
  const StereoCalibration c = open_simulator(*parse_simulator_options(options)).value()->info().calibration;
  ASSERT_FALSE(c.rectified);
  const StereoModel model = scene.model();
  const Rendered r = scene.frame(37);
  const auto rectify = [&](const Image<std::uint16_t>& raw, const CameraCalibration& camera, const Eigen::Matrix3d& R) {
    Image<std::uint16_t> out(model.width, model.height);
    const Sampler sampler{raw.view()};
    for (int v = 0; v < model.height; ++v) {
      for (int u = 0; u < model.width; ++u) {
        const Eigen::Vector2d p =
            project_raw(camera, R, {(u - model.cx_px) / model.fx_px, (v - model.cy_px) / model.fy_px, 1.0});
        out.view()(u, v) = static_cast<std::uint16_t>(
            sampler.inside(p.x(), p.y()) ? std::max(sampler(p.x(), p.y()) * sim::kGreyScale, 0.0) : 0.0);
      }
    }
    return out;
  };
  const Image<std::uint16_t> left = rectify(r.pair.left, c.left, c.prescribed->R_left);
  const Image<std::uint16_t> right = rectify(r.pair.right, c.right, c.prescribed->R_right);
  for (int band = 0; band < 3; ++band) {
    std::vector<Match> matches;
    for (int v = 4; v < model.height - 4; ++v) {
      for (int u = 4; u < model.width - 4; ++u) {
        const double d = static_cast<double>(r.disparity.view()(u, v));
        if (!std::isfinite(d) || u - d < 6.0) continue;
        const double z = model.depth_m(d);
        if (z >= kBands[band] && z < kBands[band + 1]) matches.push_back({u, v, u - d, static_cast<double>(v)});
      }
    }
    const Left l = compare(left.view(), {right.view()}, matches);
    RecordProperty("band_" + std::to_string(band), text(l));
    EXPECT_LT(std::abs(l.du), 0.01) << text(l);
    EXPECT_LT(std::abs(l.dv), 0.01) << text(l);
    EXPECT_LT(l.rms, 0.4 * l.gradient) << text(l);  // both images were interpolated once more, in both directions
  }
}

}  // namespace
}  // namespace cliquevo::drivers
