// SPDX-License-Identifier: BSD-3-Clause
// VO_ODOMETRY over a whole course: whether its covariance says how far off the pose is, and whether a filter that
// takes it in stays consistent through blank stretches.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "daemon/lcm/odometry_builder.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/simulator.h"

namespace cliquevo::test {
namespace {

// Clean cameras, and rough ones.
#ifdef CLIQUEVO_LONG
constexpr const char* kCourses[] = {
    "wheeled",           "walking", "wheeled,camera=webcam", "wheeled,camera=vibrating", "walking,camera=flexing",
    "walking,camera=sun"};
constexpr int kSeeds = 20;
constexpr int kFrames = 4001;
constexpr double kLeast = 3.0;  // of the mean; 6 is expected
constexpr double kMost = 12.0;
#else
constexpr const char* kCourses[] = {"wheeled", "walking"};
constexpr int kSeeds = 3;
constexpr int kFrames = 501;
constexpr double kLeast = 1.5;  // the mean of three runs scatters by 2
constexpr double kMost = 14.0;
#endif
constexpr double kEvery_m = 50.0;

struct CourseRun {
  std::vector<odometry_t> messages;
  std::vector<RigidTransform> truth;  // of the body
  std::vector<Vector6d> errors;       // of valid motions one after the other, in units of their covariance's roots
};

// As the simulator carries its camera: a level body below it.
RigidTransform mounting() {
  daemon::Mounting mounting;
  mounting.translation_m = {0.0, 0.0, 0.85};
  mounting.roll_pitch_yaw_deg = {0.0, 13.0, 0.0};
  return mounting.T_body_camera();
}

// The error of the last motion; nothing where it was not valid or spans a gap.
std::optional<Vector6d> white_error(const vo::Estimate& e, const RigidTransform& T_prev, const RigidTransform& T_cur,
                                    TimestampNs prev_stamp_ns) {
  if (e.status != vo::Status::valid || e.prev_stamp_ns != prev_stamp_ns) return std::nullopt;
  const Vector6d error = left_difference(e.T_prev_cur, T_prev.inverse() * T_cur);
  return Vector6d(e.covariance.llt().matrixL().solve(error));
}

// blank: frames from, to (exclusive) whose images are grey.
CourseRun run_course(const std::string& course, int seed, int frames, int blank_from = -1, int blank_to = -1) {
  CourseRun out;
  const auto options =
      drivers::parse_simulator_options(fmt::format("course={},frames={},noise_seed={}", course, frames, seed));
  EXPECT_TRUE(options.ok());
  auto simulator = drivers::open_simulator(*options);
  EXPECT_TRUE(simulator.ok());
  auto pipeline = daemon::FramePipeline::make({}, (*simulator)->info());
  EXPECT_TRUE(pipeline.ok());
  const RigidTransform T_body_camera = mounting();
  daemon::OdometryBuilder builder(T_body_camera);
  drivers::StereoPair pair;
  std::optional<RigidTransform> T_before;  // of the camera
  TimestampNs stamp_before_ns = 0;
  for (std::int64_t i = 0;; ++i) {
    const auto more = (*simulator)->next(pair);
    if (!more.ok() || !*more) break;
    if (i >= blank_from && i < blank_to) {
      pair.left.fill(90);
      pair.right.fill(90);
    }
    EXPECT_TRUE(pipeline->process(pair).ok());
    daemon::PublishedFrame frame;
    frame.index = i;
    frame.estimate = pipeline->estimate();
    odometry_t m{};
    builder.build(frame, true, frame.estimate.stamp_ns, m);
    out.messages.push_back(m);
    if (T_before) {
      const auto error = white_error(frame.estimate, *T_before, *pair.truth_T_world_camera, stamp_before_ns);
      if (error) out.errors.push_back(*error);
    }
    T_before = pair.truth_T_world_camera;
    stamp_before_ns = frame.estimate.stamp_ns;
    out.truth.push_back(T_body_camera * *pair.truth_T_world_camera * T_body_camera.inverse());
  }
  return out;
}

RigidTransform pose_of(const odometry_t& m) {
  RigidTransform T;
  T.R = Eigen::Quaterniond(m.orientation[0], m.orientation[1], m.orientation[2], m.orientation[3]).toRotationMatrix();
  T.t = {m.position[0], m.position[1], m.position[2]};
  return T;
}

Matrix6d matrix(const double (&in)[6][6]) {
  Matrix6d out;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) out(r, c) = in[r][c];
  }
  return out;
}

double normalised_error(const odometry_t& m, const RigidTransform& truth) {
  const RigidTransform T = pose_of(m);
  Vector6d error;
  error << T.t - truth.t, so3_log(T.R * truth.R.transpose());
  return error.dot(matrix(m.pose_covariance).ldlt().solve(error));
}

// What the model of successive motions (daemon/lcm/odometry_builder.h) rests on: how errors of a motion correlate with
// those of the next, and the variance of sums of many beside the sum of their variances.
class Correlation {
 public:
  static constexpr std::array<std::size_t, 3> kSums{40, 160, 640};

  void add(const std::vector<Vector6d>& errors) {
    for (std::size_t i = 1; i < errors.size(); ++i) {
      next_ += errors[i].dot(errors[i - 1]);
      own_ += errors[i].squaredNorm();
    }
    for (std::size_t of = 0; of < kSums.size(); ++of) {
      for (std::size_t i = 0; i + kSums[of] <= errors.size(); i += kSums[of]) {
        Vector6d sum = Vector6d::Zero();
        for (std::size_t k = i; k < i + kSums[of]; ++k) sum += errors[k];
        of_sums_[of] += sum.squaredNorm() / static_cast<double>(kSums[of]);
        sums_[of] += 1.0;
      }
    }
    count_ += static_cast<double>(errors.size() - 1);
  }
  double own() const { return own_ / count_; }  // 6: a motion's covariance is what its error has
  double with_next() const { return next_ / own_; }
  double of_sums(std::size_t of) const { return of_sums_[of] / std::max(1.0, sums_[of]) / own(); }

 private:
  double next_ = 0.0;
  double own_ = 0.0;
  double count_ = 0.0;
  std::array<double, kSums.size()> of_sums_{};
  std::array<double, kSums.size()> sums_{};
};

class PoseCovarianceOn : public testing::TestWithParam<const char*> {};

TEST_P(PoseCovarianceOn, HoldsAtEveryFiftyMetres) {
  const std::string course = GetParam();
  std::map<int, std::vector<double>> found;
  Correlation correlation;
  const char* fewer = std::getenv("CLIQUEVO_SEEDS");  // for a first look
  const int seeds = fewer != nullptr ? std::atoi(fewer) : kSeeds;
  for (int seed = 1; seed <= seeds; ++seed) {
    const CourseRun run = run_course(course, seed, kFrames);
    correlation.add(run.errors);
    double way_m = 0.0;
    int mark = 1;
    for (std::size_t i = 1; i < run.truth.size(); ++i) {
      way_m += (run.truth[i].t - run.truth[i - 1].t).norm();
      if (way_m < mark * kEvery_m - 0.2) continue;
      found[mark++].push_back(normalised_error(run.messages[i], run.truth[i]));
    }
  }
  ASSERT_FALSE(found.empty());
  fmt::print(
      "{}: normalised error squared of a motion {:.2f}; errors of successive motions correlate by {:.2f}; the "
      "variance of sums of 40 is {:.2f} of the sum, of 160 {:.2f}, of 640 {:.2f}\n",
      course, correlation.own(), correlation.with_next(), correlation.of_sums(0), correlation.of_sums(1),
      correlation.of_sums(2));
  constexpr double kOfAlikeMotions = -1.0 / 3.0;
  EXPECT_LT(correlation.with_next(), 0.5 * kOfAlikeMotions);
  EXPECT_GT(correlation.with_next(), 2.0 * kOfAlikeMotions);
  for (const auto& [mark, values] : found) {
    double mean = 0.0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    fmt::print("{} at {:.0f} m: normalised error squared {:.2f} ({} seeds)\n", course, mark * kEvery_m, mean,
               values.size());
    EXPECT_GE(mean, kLeast) << "at " << mark * kEvery_m << " m";
    EXPECT_LE(mean, kMost) << "at " << mark * kEvery_m << " m";
  }
}

// A name of letters and digits: "walking_sun" of "walking,camera=sun".
std::string name_of(const testing::TestParamInfo<const char*>& course) {
  std::string name;
  for (const char* c = course.param; *c != '\0'; ++c) {
    if (*c == ',') name += '_';
    if (*c == '=') name.resize(name.rfind('_') + 1);
    if (*c != ',' && *c != '=') name += *c;
  }
  return name;
}
INSTANTIATE_TEST_SUITE_P(Courses, PoseCovarianceOn, testing::ValuesIn(kCourses), name_of);

// Position of the body, along the odometry frame's axes, of what two sources say: VO_ODOMETRY's twist and a wheel's
// speed. The smallest filter that would go wrong if a twist came with a covariance that it does not keep.
class ReferenceFilter {
 public:
  // Speeds forward, in the body: measured with these variances.
  void predict(const odometry_t& m, double wheel_m_s, double wheel_variance, double dt_s) {
    const Eigen::Vector3d axis(1.0, 0.0, 0.0);
    const Eigen::Matrix3d R = pose_of(m).R;
    Eigen::Vector3d v(m.velocity[0], m.velocity[1], m.velocity[2]);
    Eigen::Matrix3d P = matrix(m.twist_covariance).topLeftCorner<3, 3>();
    // The wheel as a measurement of the forward part.
    const Eigen::Vector3d gain = P * axis / (axis.dot(P * axis) + wheel_variance);
    v += gain * (wheel_m_s - axis.dot(v));
    P -= gain * axis.transpose() * P;
    // A vehicle slides sideways, and leaves the ground, with less than 0.2 m/s.
    for (const Eigen::Vector3d& side : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
      const Eigen::Vector3d k = P * side / (side.dot(P * side) + 0.04);
      v -= k * side.dot(v);
      P -= k * side.transpose() * P;
    }
    position_ += dt_s * R * v;
    // Errors of one frame and the next share a view: they go on in part.
    covariance_ += dt_s * dt_s * (R * P * R.transpose());
    const Matrix6d pose = matrix(m.pose_covariance);
    heading_ = pose.bottomRightCorner<3, 3>();
    way_m_ += dt_s * v.norm();
  }
  double normalised_error(const Eigen::Vector3d& truth) const {
    const Eigen::Vector3d error = position_ - truth;
    const Eigen::Matrix3d P = covariance_ + way_m_ * way_m_ * heading_.trace() * Eigen::Matrix3d::Identity();
    return error.dot(P.ldlt().solve(error));
  }

 private:
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Identity() * 1e-8;
  Eigen::Matrix3d heading_ = Eigen::Matrix3d::Zero();
  double way_m_ = 0.0;
};

TEST(PoseCovariance, AFilterWithWheelSpeedStaysConsistentThroughBlankStretches) {
  constexpr double kWheelSigma_m_s = 0.02;
  const CourseRun run = run_course("wheeled", 1, 200, 80, 110);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, kWheelSigma_m_s);
  ReferenceFilter filter;
  int guesses = 0;
  for (std::size_t i = 1; i < run.messages.size(); ++i) {
    const double dt_s = static_cast<double>(run.messages[i].utime - run.messages[i - 1].utime) * 1e-6;
    const RigidTransform moved = run.truth[i - 1].inverse() * run.truth[i];
    const double wheel_m_s = (moved.R.transpose() * moved.t).x() / dt_s + noise(random);
    filter.predict(run.messages[i], wheel_m_s, kWheelSigma_m_s * kWheelSigma_m_s, dt_s);
    guesses += run.messages[i].pose_is_guess;
    if (i % 10 == 0) {
      EXPECT_LT(filter.normalised_error(run.truth[i].t), 16.3) << "frame " << i;  // 99.9 % of three degrees of freedom
    }
    if (run.messages[i].pose_is_guess != 0) {
      // The guess alone is as uncertain as it says.
      EXPECT_LT(normalised_error(run.messages[i], run.truth[i]), 22.5) << "frame " << i;
    }
  }
  EXPECT_GE(guesses, 25);
}

}  // namespace
}  // namespace cliquevo::test
