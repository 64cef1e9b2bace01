// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/trajectory_file.h"

#include <fstream>
#include <sstream>

#include "tests/support/test_data.h"

namespace cliquevo::daemon {
namespace {

std::string file_with(const std::string& text) {
  const std::string path = test::scratch_dir() + "/trajectory.txt";
  std::ofstream(path) << text;
  return path;
}

RigidTransform some_pose() {
  RigidTransform T;
  T.R = so3_exp({0.3, -0.2, 0.1});
  T.t = {1.0 / 3.0, -2.0e-4, 12345.678901};
  return T;
}

TEST(TrajectoryFile, KittiKeepsThirteenDigitsAndReadsBack) {
  const std::string path = test::scratch_dir() + "/k.txt";
  {
    auto writer = TrajectoryWriter::open(path, TrajectoryFormat::kitti);
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE(writer->append(5, {}).ok());
    ASSERT_TRUE(writer->append(6, some_pose()).ok());
  }
  const auto read = read_trajectory(path);
  ASSERT_TRUE(read.ok()) << read.error().line();
  EXPECT_EQ(read->format, TrajectoryFormat::kitti);
  ASSERT_EQ(read->poses.size(), 2u);
  EXPECT_NEAR((read->poses[1].T_world_camera.R - some_pose().R).norm(), 0.0, 1e-12);
  EXPECT_NEAR((read->poses[1].T_world_camera.t - some_pose().t).norm(), 0.0, 1e-8);
}

TEST(TrajectoryFile, TumKeepsNanosecondsAndRotation) {
  const TimestampNs stamp = 1'700'000'000'123'456'789;
  const std::string line = format_pose(TrajectoryFormat::tum, stamp, some_pose());
  EXPECT_EQ(line.substr(0, line.find(' ')), "1700000000.123456789");
  const auto read = read_trajectory(file_with("# stamp ...\n" + line + "\n"));
  ASSERT_TRUE(read.ok()) << read.error().line();
  EXPECT_EQ(read->format, TrajectoryFormat::tum);
  EXPECT_EQ(read->poses[0].stamp_ns, stamp);
  EXPECT_NEAR((read->poses[0].T_world_camera.R - some_pose().R).norm(), 0.0, 1e-11);
}

TEST(TrajectoryFile, TheIdentityIsWrittenWithoutMinusZero) {
  RigidTransform T;
  T.t = {-0.0, 0.0, -0.0};
  EXPECT_EQ(format_pose(TrajectoryFormat::kitti, 0, T).find('-'), std::string::npos);
}

TEST(TrajectoryFile, TimesBelowZeroAndWithExponentAreUnderstood) {
  const auto read = read_trajectory(file_with("-0.5 0 0 0 0 0 0 1\n+1 0 0 0 0 0 0 1\n1.5e1 0 0 0 0 0 0 1\n"));
  ASSERT_FALSE(read.ok());  // "+1" is no number
  const auto good = read_trajectory(file_with("-0.5 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n1.5e1 0 0 0 0 0 0 1\n"));
  ASSERT_TRUE(good.ok()) << good.error().line();
  EXPECT_EQ(good->poses[0].stamp_ns, -500'000'000);
  EXPECT_EQ(good->poses[2].stamp_ns, 15'000'000'000);
  EXPECT_EQ(format_pose(TrajectoryFormat::tum, -500'000'000, {}).substr(0, 12), "-0.500000000");
}

TEST(TrajectoryFile, ReferencesOfEurocAndKitti360AreToldByTheirColumns) {
  const auto euroc =
      read_trajectory(file_with("#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z, v, v, v, b, b, b, b, b, b\n"
                                "1403636580838555648,4.6,-1.7,0.7,0.5,-0.5,0.5,-0.5,0,0,0,0,0,0,0,0,0\n"
                                "1403636580843555648,4.7,-1.7,0.7,1,0,0,0,0,0,0,0,0,0,0,0,0\n"));
  ASSERT_TRUE(euroc.ok()) << euroc.error().line();
  EXPECT_EQ(euroc->format, TrajectoryFormat::tum);
  EXPECT_TRUE(euroc->of_body);
  EXPECT_EQ(euroc->poses[0].stamp_ns, 1403636580838555648);
  EXPECT_NEAR((euroc->poses[1].T_world_camera.R - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12);
  // Turned by 120 degrees about (-1, 1, -1).
  EXPECT_NEAR((euroc->poses[0].T_world_camera.R * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY()).norm(), 0.0,
              1e-12);
  const auto numbered =
      read_trajectory(file_with("1 1 0 0 386.5 0 1 0 0 0 0 1 0 0 0 0 1\n4 1 0 0 387 0 1 0 0 0 0 1 0 0 0 0 1\n"));
  ASSERT_TRUE(numbered.ok()) << numbered.error().line();
  EXPECT_TRUE(numbered->numbered);
  EXPECT_EQ(numbered->poses[1].frame, 4);
  EXPECT_FALSE(
      read_trajectory(file_with("4 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n1 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n")).ok());
}

TEST(TrajectoryFile, WhatIsNotAPoseIsNamedWithItsLine) {
  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  const struct {
    std::string text;
    std::string says;
  } cases[] = {
      {"", "no pose"},
      {good + "1 0 0\n", ":2:"},
      {good + "\n1 0 0 0 0 1 0 0 0 0 1 x\n", ":3: 'x' is not a number"},
      {good + "1 0 0 nan 0 1 0 0 0 0 1 0\n", ":2: 'nan'"},
      {good + "1 0 0 0 0 1 0 0 0 0 5 0\n", ":2: columns"},
      {good + "0 0 0 0 0 0 0 1\n", ":2: 8 numbers after lines of 12"},
      {"1 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", ":2: times must not fall"},
      {"1 0 0 0 0 0 0 0.5\n", ":1: qx"},
  };
  for (const auto& bad : cases) {
    const auto read = read_trajectory(file_with(bad.text));
    ASSERT_FALSE(read.ok()) << bad.text;
    EXPECT_NE(read.error().line().find(bad.says), std::string::npos) << read.error().line();
  }
  EXPECT_FALSE(read_trajectory("/nowhere/t.txt").ok());
}

TEST(TrajectoryFile, EachLineIsInTheFileAsSoonAsItIsAppended) {
  const std::string path = test::scratch_dir() + "/growing.txt";
  auto writer = TrajectoryWriter::open(path, TrajectoryFormat::kitti);
  ASSERT_TRUE(writer.ok());
  for (std::size_t lines = 1; lines < 4; ++lines) {
    ASSERT_TRUE(writer->append(0, {}).ok());
    const auto read = read_trajectory(path);
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(read->poses.size(), lines);
  }
}

TEST(TrajectoryFile, AnImpossiblePathAndAFullDiskAreErrors) {
  EXPECT_FALSE(TrajectoryWriter::open("/nowhere/t.txt", TrajectoryFormat::tum).ok());
  auto full = TrajectoryWriter::open("/dev/full", TrajectoryFormat::tum);
  ASSERT_TRUE(full.ok());
  EXPECT_FALSE(full->append(0, {}).ok());
}

}  // namespace
}  // namespace cliquevo::daemon
