// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/isa.h"
#include "drivers/simulator.h"
#include "drivers/simulator/course.h"
#include "drivers/simulator/renderer.h"
#include "drivers/simulator/shade.h"
#include "drivers/simulator/world.h"
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
    for (const auto* image : {&pair.left, &pair.right}) {
      for (int y = 0; y < image->height(); ++y)
        r.pixels.insert(r.pixels.end(), image->view().row(y), image->view().row(y) + image->width());
    }
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

TEST(Simulator, ShadingKernelsOfEveryInstructionSetGiveTheSameBits) {
  const SimulatorOptions options = small("");
  const sim::Course course(options);
  const sim::World world(options, course);
  std::vector<sim::CleanPair> pairs(2);
  sim::RenderScratch scratch;
  const sim::Renderer plain(options, course, world, sim::shade_tables().reference());
  plain.render(3, scratch, pairs[0]);
  for (const Isa isa : sim::shade_tables().usable()) {
    const sim::Renderer tested(options, course, world, *sim::shade_tables().find(isa));
    tested.render(3, scratch, pairs[1]);
    for (int y = 0; y < options.height; ++y) {
      ASSERT_EQ(std::memcmp(pairs[0].left.view().row(y), pairs[1].left.view().row(y), 2U * 128U), 0)
          << isa_name(isa) << " " << y;
      ASSERT_EQ(std::memcmp(pairs[0].right.view().row(y), pairs[1].right.view().row(y), 2U * 128U), 0)
          << isa_name(isa) << " " << y;
    }
  }
}

// FNV-1a.
std::uint64_t checksum(const std::vector<std::uint8_t>& bytes) {
  std::uint64_t sum = 14695981039346656037ULL;
  for (const std::uint8_t b : bytes) sum = (sum ^ b) * 1099511628211ULL;
  return sum;
}

// Written down once (g++ 12 on x86); clang and arm64 must draw the same worlds, nothing read from a store.
TEST(Simulator, DrawsTheSamePicturesWhateverTheCompiler) {
  struct Drawn {
    const char* options;
    std::uint64_t sum;
  };
  const Drawn kDrawn[] = {
      {"", 0xadd9aebc8ebf622ULL},
      {"movers=6,world_seed=3,course=walking", 0x5576b5399b6e394aULL},
      {"scene=lorry,shadow=on,world_seed=2,rocks=300", 0xd82915e497eea8d2ULL},
      {"scene=water,course=turn,fault=flare", 0xe4885332f95a23afULL},
      {"width=160,height=120,focal_px=180,raw=on,frames=2", 0xd99df95fe19ceeb0ULL},
      {"camera=webcam", 0x690a2e2ce055cd9aULL},
      {"camera=flexing", 0x48ec687a84b1eb18ULL},
      {"camera=vibrating", 0xe83184deffeb2f42ULL},
      {"camera=action", 0xad2ff65cfdf80fadULL},
      {"camera=sun", 0xe4edf1f76b48359eULL},
  };
  for (const Drawn& d : kDrawn) EXPECT_EQ(checksum(run(small(d.options)).pixels), d.sum) << "'" << d.options << "'";
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

TEST(Simulator, TheCacheRemovesWhatItMadeItselfAndNothingElse) {
  namespace fs = std::filesystem;
  SimulatorOptions options = small("");
  options.cache_dir = test::scratch_dir();
  const std::string root = options.cache_dir;
  run(options);
  ASSERT_EQ(std::distance(fs::directory_iterator(root), fs::directory_iterator()), 1);
  const fs::path scene = fs::directory_iterator(root)->path();
  // Named alike, but of somebody else: no note, a note of another scene, a link, a file.
  fs::create_directories(root + "/simulator-results");
  std::ofstream(root + "/simulator-results/thesis.txt") << std::string(100'000, 'x');
  fs::copy(scene, root + "/simulator-wheeled-0123456789abcdef");
  const std::string elsewhere = test::scratch_dir();
  fs::copy(scene, elsewhere + "/kept");
  fs::create_directory_symlink(elsewhere + "/kept", root + "/" + scene.filename().string() + "x");
  std::ofstream(root + "/simulator-plan.md") << "plan";
  // Something of the user's beside the pairs of a scene of ours.
  std::ofstream(scene / "notes.txt") << "mine";
  options.world_seed = 2;
  options.cache_limit_gb = 0.0;  // everything must go
  run(options);
  EXPECT_TRUE(fs::exists(root + "/simulator-results/thesis.txt"));
  EXPECT_TRUE(fs::exists(root + "/simulator-wheeled-0123456789abcdef/000000.pair"));
  EXPECT_TRUE(fs::exists(elsewhere + "/kept/000000.pair"));
  EXPECT_TRUE(fs::exists(root + "/simulator-plan.md"));
  EXPECT_TRUE(fs::exists(scene / "notes.txt"));
  EXPECT_FALSE(fs::exists(scene / "000000.pair"));
}

TEST(Simulator, AFaultTouchesItsFramesAndNoOthers) {
  const Frames good = run(small(""));
  const std::size_t image = 128U * 96U;
  for (const char* fault : {"blank", "noise", "frozen", "covered", "flare", "night"}) {
    const Frames bad = run(small(std::string("fault_first=2,fault_frames=2,fault=") + fault));
    ASSERT_EQ(bad.pixels.size(), good.pixels.size());
    for (std::size_t k = 0; k < 5; ++k) {
      const bool same =
          std::memcmp(good.pixels.data() + 2 * k * image, bad.pixels.data() + 2 * k * image, 2 * image) == 0;
      EXPECT_EQ(same, k < 2 || k > 3) << fault << " frame " << k;
    }
    if (std::string(fault) == "frozen") {
      for (std::size_t k = 2; k < 4; ++k)
        EXPECT_EQ(std::memcmp(bad.pixels.data() + 3 * image, bad.pixels.data() + (2 * k + 1) * image, image), 0) << k;
    }
  }
}

TEST(Simulator, ScenesDiffer) {
  const Frames natural = run(small(""));
  EXPECT_NE(natural.pixels, run(small("scene=water")).pixels);
  EXPECT_NE(natural.pixels, run(small("scene=lorry")).pixels);
  for (const char* beside : {"railings=on", "walls=on", "glass=on"})
    EXPECT_NE(natural.pixels, run(small(beside)).pixels) << beside;
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
