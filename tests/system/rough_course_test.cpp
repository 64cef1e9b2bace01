// SPDX-License-Identifier: BSD-3-Clause
// Short simulated courses seen by each rough camera, and long ones under the label bench.
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

#ifdef CLIQUEVO_LONG
constexpr int kFrames = 4000;
constexpr double kTimeoutS = 3600.0;
#else
constexpr int kFrames = 200;
constexpr double kTimeoutS = 300.0;
#endif

struct Camera {
  const char* name;
  double segments_pct;
  friend std::ostream& operator<<(std::ostream& out, const Camera& camera) { return out << camera.name; }
};
constexpr Camera kCameras[] = {{"sun", 0.1}, {"flexing", 0.1}, {"webcam", 0.3}, {"vibrating", 0.1}, {"action", 0.4}};
constexpr int kMostFailed = kFrames / 200;  // flexing: the first frame, as long as nothing is known of the rig

class RoughCourse : public testing::TestWithParam<Camera> {
 protected:
  static void expect_followed(const std::string& course) {
    const std::string path = scratch_dir() + "/stats.json";
    const std::string source = fmt::format("sim:course={},frames={},camera={}", course, kFrames, GetParam().name);
    const Finished done = Subprocess({binary("cliquevo"), "replay", source, "--stats", path}).wait(kTimeoutS);
    ASSERT_EQ(done.exit_code, 0) << done.err;
    const json stats = json::parse(read_file(path));
    const int valid = kFrames - 1 - stats["summary"]["failed"].get<int>();
    const double end_pct = stats["reference"]["end_pct"].get<double>();
    const double segments_pct = stats["reference"]["t_err_pct"].get<double>();
    fmt::print("{} {}: {} of {} valid, end {:.3f} %, segments {:.3f} %\n", course, GetParam().name, valid, kFrames - 1,
               end_pct, segments_pct);
    EXPECT_GE(valid, kFrames - 1 - kMostFailed);
    EXPECT_LE(segments_pct, GetParam().segments_pct);
  }
};

TEST_P(RoughCourse, WheeledIsFollowed) { expect_followed("wheeled"); }

TEST_P(RoughCourse, WalkingIsFollowed) { expect_followed("walking"); }

INSTANTIATE_TEST_SUITE_P(Camera, RoughCourse, testing::ValuesIn(kCameras),
                         [](const auto& camera) { return std::string(camera.param.name); });

}  // namespace
}  // namespace cliquevo::test
