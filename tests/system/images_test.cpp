// SPDX-License-Identifier: BSD-3-Clause
// Images as users' cameras and programs write them, through the whole of `cliquevo replay`.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "daemon/pipeline/trajectory_file.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

struct Played {
  Finished process;
  std::vector<double> steps_m;  // way from frame to frame
};

Played play(const std::string& recording, const std::vector<std::string>& more = {}) {
  const std::string path = scratch_dir() + "/trajectory.txt";
  std::vector<std::string> command{binary("cliquevo"), "replay", recording, "--trajectory", path};
  command.insert(command.end(), more.begin(), more.end());
  Played out{run(command), {}};
  if (const auto trajectory = daemon::read_trajectory(path)) {
    for (std::size_t i = 1; i < trajectory->poses.size(); ++i) {
      const Eigen::Vector3d way = trajectory->poses[i].T_world_camera.t - trajectory->poses[i - 1].T_world_camera.t;
      out.steps_m.push_back(way.norm());
    }
  }
  return out;
}

// A writable copy whose times fit its five pairs.
std::string bayer_recording() {
  const std::string folder = scratch_dir();
  for (const char* side : {"left", "right"}) {
    fs::create_directories(folder + "/" + side);
    for (const auto& entry : fs::directory_iterator(field_dir() + "/19-bayer/" + side)) {
      std::ifstream in(entry.path(), std::ios::binary);
      std::ofstream(folder + "/" + side + "/" + entry.path().filename().string(), std::ios::binary) << in.rdbuf();
    }
  }
  std::ofstream(folder + "/calib.txt") << read_file(field_dir() + "/19-bayer/calib.txt");
  std::ofstream(folder + "/times.txt") << "0\n0.1\n0.2\n0.3\n0.4\n";
  return folder;
}

void expect_steps(const Played& played, std::size_t count, double step_m, double tolerance) {
  EXPECT_EQ(played.process.exit_code, 0) << played.process.err << played.process.out;
  ASSERT_EQ(played.steps_m.size(), count);
  for (const double way : played.steps_m) EXPECT_NEAR(way, step_m, tolerance * step_m);
}

TEST(Images, TwelveBitsInPngAndPgmGiveTheirWay) {
  CLIQUEVO_NEEDS_FIELD("04-12bit-in-16");
  for (const char* kind : {"png", "pgm"}) {
    const Played played = play(field_dir() + "/04-12bit-in-16/" + kind, {"--strict"});
    expect_steps(played, 2, 0.06, 0.03);
    const std::string said = "scaled by 1/16";
    const std::size_t at = played.process.out.find(said);
    ASSERT_NE(at, std::string::npos) << played.process.out;
    EXPECT_EQ(played.process.out.find(said, at + 1), std::string::npos) << "said twice";
  }
}

TEST(Images, AMosaicIsToldAndGivesItsWay) {
  CLIQUEVO_NEEDS_FIELD("19-bayer");
  const std::string folder = bayer_recording();
  const Played found = play(folder, {"--strict"});
  expect_steps(found, 4, 0.06, 0.03);
  EXPECT_NE(found.process.out.find("Bayer mosaic"), std::string::npos) << found.process.out;
  const Played named = play(folder, {"--strict", "--bayer", "rggb"});
  EXPECT_EQ(found.steps_m, named.steps_m);
  const Played raw = play(folder, {"--bayer", "none"});
  EXPECT_EQ(raw.process.out.find("Bayer mosaic"), std::string::npos);
  EXPECT_EQ(play(folder, {"--bayer", "gbgr"}).process.exit_code, 2);
}

TEST(Images, AnImageOrMaskOfAbsurdSizeIsOneLineAtOnce) {
  CLIQUEVO_NEEDS_FIELD("19-bayer");
  const std::string folder = bayer_recording();
  std::ofstream(folder + "/mask_left.png", std::ios::binary) << "P5 30000 30000 255\n";
  Finished done = run({binary("cliquevo"), "replay", folder});
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(lines_of(done.err).size(), 1U) << done.err;
  EXPECT_NE(done.err.find("30000x30000"), std::string::npos) << done.err;
  fs::remove(folder + "/mask_left.png");
  for (const char* side : {"left", "right"}) {
    for (const auto& entry : fs::directory_iterator(folder + "/" + side)) {
      std::ofstream(entry.path(), std::ios::binary) << "P6 30000 30000 65535\n";
    }
  }
  done = run({binary("cliquevo"), "replay", folder});
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(lines_of(done.err).size(), 1U) << done.err;
  EXPECT_NE(done.err.find("30000x30000"), std::string::npos) << done.err;
}

// What a package pulls in follows from this.
TEST(Images, TheProgramsLinkNoOpenCV) {
  for (const char* program : {"cliquevo", "cliquevod"}) {
    if (!fs::exists(binary(program))) continue;
    const Finished done = run({"ldd", binary(program)});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.out.find("opencv"), std::string::npos) << program;
    EXPECT_NE(done.out.find("libspng"), std::string::npos) << program;
  }
}

}  // namespace
}  // namespace cliquevo::test
