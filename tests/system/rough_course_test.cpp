// SPDX-License-Identifier: BSD-3-Clause
// Short simulated courses seen by each rough camera, and long ones under the label bench.
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

class RoughCourse : public testing::TestWithParam<const char*> {
 protected:
  // At least 99.5 % of the frames valid, the end off by at most 0.3 % of the way.
  static void expect_followed(const std::string& course) {
    const std::string path = scratch_dir() + "/stats.json";
    const std::string source = fmt::format("sim:course={},frames={},camera={}", course, kFrames, GetParam());
    const Finished done = Subprocess({binary("cliquevo"), "replay", source, "--stats", path}).wait(kTimeoutS);
    ASSERT_EQ(done.exit_code, 0) << done.err;
    const json stats = json::parse(read_file(path));
    const int valid = kFrames - 1 - stats["summary"]["failed"].get<int>();
    const double end_pct = stats["reference"]["end_pct"].get<double>();
    fmt::print("{} {}: {} of {} valid, end {:.3f} %\n", course, GetParam(), valid, kFrames - 1, end_pct);
    EXPECT_GE(valid, 0.995 * (kFrames - 1));
    EXPECT_LE(end_pct, 0.3);
  }
};

TEST_P(RoughCourse, WheeledIsFollowed) { expect_followed("wheeled"); }

TEST_P(RoughCourse, WalkingIsFollowed) { expect_followed("walking"); }

INSTANTIATE_TEST_SUITE_P(Camera, RoughCourse, testing::Values("webcam", "flexing", "vibrating", "action", "sun"),
                         [](const auto& camera) { return std::string(camera.param); });

}  // namespace
}  // namespace cliquevo::test
