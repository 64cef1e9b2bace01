// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/simulator.h"
#include "tests/support/test_data.h"

namespace cliquevo::drivers {
namespace {

SimulatorOptions small(const std::string& more) {
  const auto o = parse_simulator_options("width=128,height=96,focal_px=140,frames=5,cache_dir=none," + more);
  EXPECT_TRUE(o.ok());
  return *o;
}

struct Frames {
  std::vector<std::uint8_t> pixels;
  std::vector<TimestampNs> stamps;
};

Frames run(const SimulatorOptions& options) {
  Frames r;
  auto source = open_simulator(options);
  EXPECT_TRUE(source.ok());
  StereoPair pair;
  while (true) {
    const auto more = source.value()->next(pair);
    EXPECT_TRUE(more.ok());
    if (!*more) break;
    for (const auto* image : {&pair.left, &pair.right})
      for (int y = 0; y < image->height(); ++y)
        r.pixels.insert(r.pixels.end(), image->view().row(y), image->view().row(y) + image->width());
    r.stamps.push_back(pair.stamp_ns);
  }
  return r;
}

TEST(Simulator, SameSeedsGiveTheSameBytesWhateverTheWorkers) {
  const Frames one = run(small("workers=1"));
  const Frames three = run(small("workers=3"));
  EXPECT_EQ(one.pixels.size(), 5U * 2U * 128U * 96U);
  EXPECT_EQ(one.pixels, three.pixels);
  EXPECT_EQ(one.stamps, three.stamps);
}

TEST(Simulator, SeedsChangeNoiseAndWorld) {
  const Frames one = run(small(""));
  EXPECT_NE(one.pixels, run(small("noise_seed=2")).pixels);
  EXPECT_NE(one.pixels, run(small("world_seed=2")).pixels);
  const Frames clean = run(small("noise_sigma=0,shot_noise=off"));
  EXPECT_EQ(clean.pixels, run(small("noise_sigma=0,shot_noise=off,noise_seed=2")).pixels);
}

TEST(Simulator, EverySecondFrameIsTheSecondFrameOfTheSameRender) {
  const Frames all = run(small("frames=6"));
  const Frames half = run(small("frames=6,every=2"));
  const std::size_t pair = 2U * 128U * 96U;
  ASSERT_EQ(half.stamps.size(), 3U);
  EXPECT_EQ(half.stamps[1], all.stamps[2]);
  EXPECT_EQ(std::memcmp(half.pixels.data() + pair, all.pixels.data() + 2 * pair, pair), 0);
}

TEST(Simulator, LengthOfTheRunDoesNotChangeItsFrames) {
  const Frames five = run(small(""));
  const Frames two = run(small("frames=2"));
  EXPECT_EQ(std::memcmp(five.pixels.data(), two.pixels.data(), two.pixels.size()), 0);
}

TEST(Simulator, CachedFramesAreTheRenderedOnesAndTornFilesAreRenderedAgain) {
  SimulatorOptions options = small("");
  const Frames fresh = run(options);
  options.cache_dir = test::scratch_dir();
  EXPECT_EQ(run(options).pixels, fresh.pixels);  // fills it
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(options.cache_dir))
    if (entry.path().extension() == ".pair") files.push_back(entry.path());
  ASSERT_EQ(files.size(), 5U);
  EXPECT_EQ(run(options).pixels, fresh.pixels);  // reads it
  std::filesystem::resize_file(files[0], std::filesystem::file_size(files[0]) / 2);
  std::fstream broken(files[1], std::ios::in | std::ios::out | std::ios::binary);
  broken.seekp(2000);
  broken.write("torn", 4);
  broken.close();
  EXPECT_EQ(run(options).pixels, fresh.pixels);
}

TEST(Simulator, StandingCameraHasIdentityTruth) {
  auto source = open_simulator(small("course=standing"));
  ASSERT_TRUE(source.ok());
  StereoPair pair;
  for (int k = 0; k < 5; ++k) {
    ASSERT_TRUE(*source.value()->next(pair));
    ASSERT_TRUE(pair.truth_T_world_camera.has_value());
    EXPECT_LT(pair.truth_T_world_camera->t.norm(), 1e-12);
  }
  EXPECT_FALSE(*source.value()->next(pair));
}

}  // namespace
}  // namespace cliquevo::drivers
