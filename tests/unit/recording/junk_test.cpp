// SPDX-License-Identifier: BSD-3-Clause
// Junk in the parsers ends in one clear error or in a sane result, never in a crash or a NaN.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/fuzz/recording_parsers.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo {
namespace {

std::string feed(int parser, const std::string& text) {
  const std::string input = static_cast<char>(parser) + text;
  return fuzz::parse_anything(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

TEST(junk, mutated_files_of_every_format) {
  const test::Rig rig = test::make_rig();
  const std::vector<std::string> files{
      test::kitti_calibration(300.0, 320.0, 321.0),
      test::kitti_raw_txt(rig),
      "Pinhole 300 300 320 240 0\n640 480\ncrop\n640 480\n0.12\n",
      "RadTan 0.5 0.6 0.5 0.5 -0.3 0.1 0.001 0.002\n640 480\n250 250 160 120 0\n320 240\n0.12\n",
      test::ros_yaml(rig, true),
      test::kalibr_yaml(rig),
      test::euroc_yaml(rig, true),
      test::opencv_yaml(rig, true),
      "0.0\n1.036e-01\n0.2\n1687709319.100414\n1687709319200000000\n",
      "2011-09-26 14:05:37.977365760\n2011-09-26 14:05:38.081148416\n",
      "#timestamp [ns],filename\n1403636579763555584,1403636579763555584.png\n",
  };
  std::uint64_t state = 1;
  for (const std::string& file : files) {
    for (int parser = 0; parser < fuzz::parser_count(); ++parser) EXPECT_EQ(feed(parser, file), "");
    for (int i = 0; i < 200; ++i) {
      const std::string text = fuzz::mutated(file, state);
      for (int parser = 0; parser < fuzz::parser_count(); ++parser) {
        const std::string bad = feed(parser, text);
        ASSERT_EQ(bad, "") << text;
      }
    }
  }
}

TEST(junk, noise) {
  std::uint64_t state = 2;
  for (int i = 0; i < 2000; ++i) {
    std::string text(state % 200, '\0');
    for (char& c : text) {
      state = state * 6364136223846793005U + 1442695040888963407U;
      c = static_cast<char>(i % 2 == 0 ? state >> 56U : "0123456789.-+e \n:[]{},#&*!"[(state >> 56U) % 26]);
    }
    ASSERT_EQ(feed(i % fuzz::parser_count(), text), "") << text;
    state += 77;
  }
}

TEST(junk, deep_nesting) {
  for (const char* bracket : {"[", "{", "- ", "a: [", "? ", "&a [", "!!x "}) {
    std::string text;
    for (int i = 0; i < 20000; ++i) text += bracket;
    for (int parser = 0; parser < fuzz::parser_count(); ++parser) EXPECT_EQ(feed(parser, text), "") << bracket;
    EXPECT_EQ(feed(4, "cam0: " + text), "") << bracket;
  }
}

}  // namespace
}  // namespace cliquevo
