// SPDX-License-Identifier: BSD-3-Clause
// Trajectories as other projects write them: one path, in every format.
#include <fstream>
#include <functional>

#include <fmt/format.h>

#include "daemon/pipeline/trajectory_file.h"
#include "tests/support/test_data.h"

namespace cliquevo::daemon {
namespace {

constexpr int kPoses = 5;
constexpr TimestampNs kStart = 1'403'636'579'763'555'584;
constexpr TimestampNs kStep = 50'000'000;

struct Pose {
  TimestampNs ns = 0;
  Eigen::Vector3d t;
  Eigen::Quaterniond q;

  std::string place(const char* between) const {
    return fmt::format("{:.9f}{}{:.9f}{}{:.9f}", t.x(), between, t.y(), between, t.z());
  }
  std::string xyzw(const char* between) const {
    return fmt::format("{:.9f}{}{:.9f}{}{:.9f}{}{:.9f}", q.x(), between, q.y(), between, q.z(), between, q.w());
  }
  std::string wxyz(const char* between) const {
    return fmt::format("{:.9f}{}{:.9f}{}{:.9f}{}{:.9f}", q.w(), between, q.x(), between, q.y(), between, q.z());
  }
  std::string seconds() const { return fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000); }
};

Pose pose_of(int i) {
  return {kStart + i * kStep,
          {0.3 * i, -0.01 * i * i, 1.0 + 0.1 * i},
          Eigen::Quaterniond(so3_exp({0.02 * i, 0.1 * i, 0.3 - 0.05 * i}))};
}

Result<Trajectory> read(const std::string& heading, const std::function<std::string(const Pose&)>& row,
                        const std::string& name = "trajectory.txt") {
  std::string text = heading.empty() ? "" : heading + "\n";
  for (int i = 0; i < kPoses; ++i) text += row(pose_of(i)) + "\n";
  const std::string path = test::scratch_dir() + "/" + name;
  std::ofstream(path) << text;
  return read_trajectory(path);
}

// `of_axes`: what the file's axes of the moving frame are turned by.
void expect_path(const Result<Trajectory>& read, std::int64_t stamp_unit_ns,
                 const Eigen::Matrix3d& of_axes = Eigen::Matrix3d::Identity()) {
  ASSERT_TRUE(read.ok()) << read.error().line();
  ASSERT_EQ(read->poses.size(), static_cast<std::size_t>(kPoses));
  EXPECT_EQ(read->format, stamp_unit_ns > 0 ? TrajectoryFormat::tum : TrajectoryFormat::kitti);
  for (int i = 0; i < kPoses; ++i) {
    const StampedPose& pose = read->poses[static_cast<std::size_t>(i)];
    const Pose truth = pose_of(i);
    const TimestampNs stamp = stamp_unit_ns > 0 ? truth.ns / stamp_unit_ns * stamp_unit_ns : 0;
    EXPECT_EQ(pose.stamp_ns, stamp) << i;
    EXPECT_LT((pose.T_world_camera.t - truth.t).norm(), 1e-8) << i;
    EXPECT_LT((pose.T_world_camera.R - truth.q.toRotationMatrix() * of_axes).norm(), 1e-7) << i;
  }
}

void expect_error(const Result<Trajectory>& read, const std::string& says) {
  ASSERT_FALSE(read.ok()) << says;
  EXPECT_NE(read.error().line().find(says), std::string::npos) << read.error().line();
  EXPECT_EQ(read.error().line().find('\n'), std::string::npos);
}

std::string tum(const Pose& p) { return p.seconds() + " " + p.place(" ") + " " + p.xyzw(" "); }

TEST(TrajectoryFormats, AHeadingDecidesTheOrderOfTheColumns) {
  const auto w_first = [](const Pose& p) { return p.seconds() + "," + p.place(",") + "," + p.wxyz(","); };
  const auto w_last = [](const Pose& p) { return p.seconds() + "," + p.place(",") + "," + p.xyzw(","); };
  for (const char* heading :
       {"timestamp,x,y,z,qw,qx,qy,qz", "#timestamp [s], p_x [m], p_y [m], p_z [m], q_w [], q_x [], q_y [], q_z []",
        "time,tx,ty,tz,q_w,q_x,q_y,q_z",
        "t,position.x,position.y,position.z,orientation.w,orientation.x,orientation.y,"
        "orientation.z",
        "\"Timestamp\",\"PosX\",\"PosY\",\"PosZ\",\"rotW\",\"rotX\",\"rotY\",\"rotZ\"",
        "stamp,translation_x,translation_y,translation_z,rotation_qw,rotation_qx,rotation_qy,rotation_qz",
        "# timestamp(s) x y z qw qx qy qz", "# columns: timestamp x y z qw qx qy qz"}) {
    SCOPED_TRACE(heading);
    const auto file = read(heading, w_first);
    expect_path(file, 1);
    EXPECT_FALSE(file->of_body);
  }
  expect_path(read("timestamp,x,y,z,qx,qy,qz,qw", w_last), 1);
  // Positions behind the orientation, and in mm.
  expect_path(read("qw,qx,qy,qz,time_ns,z_mm,y_mm,x_mm",
                   [](const Pose& p) {
                     return fmt::format("{},{},{:.6f},{:.6f},{:.6f}", p.wxyz(","), p.ns, 1e3 * p.t.z(), 1e3 * p.t.y(),
                                        1e3 * p.t.x());
                   }),
              1);
}

TEST(TrajectoryFormats, ColumnsOfOtherQuantitiesAreLeftOut) {
  const auto openvins = read("# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11",
                             [](const Pose& p) { return tum(p) + " 0.1 0 0 0.1 0 0.1 0.2"; });
  expect_path(openvins, 1);
  EXPECT_TRUE(openvins->of_body);
  expect_path(read("# id timestamp tx ty tz qx qy qz qw",
                   [](const Pose& p) { return fmt::format("{} {}", (p.ns - kStart) / kStep, tum(p)); }),
              1);
  const auto kimera = read("#timestamp,x,y,z,qw,qx,qy,qz,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz", [](const Pose& p) {
    return fmt::format("{},{},{},1,2,3,4,5,6,7,8,9", p.ns, p.place(","), p.wxyz(","));
  });
  expect_path(kimera, 1);
  EXPECT_TRUE(kimera->of_body);
}

TEST(TrajectoryFormats, MessagesOfRosAreOfTheFrameThatTheyName) {
  const std::string heading =
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.child_frame_id,"
      "field.pose.pose.position.x,field.pose.pose.position.y,field.pose.pose.position.z,field.pose.pose.orientation.x,"
      "field.pose.pose.orientation.y,field.pose.pose.orientation.z,field.pose.pose.orientation.w,field.pose."
      "covariance0,"
      "field.twist.twist.linear.x,field.twist.twist.angular.x";
  const auto of = [&](const std::string& child) {
    return read(heading, [&](const Pose& p) {
      return fmt::format("{},7,{},,{},{},{},0.1,5,6", p.ns, p.ns, child, p.place(","), p.xyzw(","));
    });
  };
  expect_path(of("base_link"), 1);
  EXPECT_TRUE(of("base_link")->of_body);
  expect_path(of("cam0_optical"), 1);
  EXPECT_FALSE(of("cam0_optical")->of_body);
}

TEST(TrajectoryFormats, StampsAreReadInTheUnitInWhichTheyCome) {
  const auto with = [](const std::function<std::string(const Pose&)>& stamp) {
    return read("", [&](const Pose& p) { return stamp(p) + " " + p.place(" ") + " " + p.xyzw(" "); });
  };
  expect_path(with([](const Pose& p) { return fmt::format("{}.000000", p.ns); }), 1);  // ORB-SLAM3
  expect_path(with([](const Pose& p) { return fmt::format("{}", p.ns); }), 1);
  expect_path(with([](const Pose& p) { return fmt::format("{}", p.ns / 1000); }), 1000);
  expect_path(with([](const Pose& p) { return fmt::format("{}", p.ns / 1'000'000); }), 1'000'000);
  expect_path(read("#sec,nsec,x,y,z,qx,qy,qz,qw",
                   [](const Pose& p) {
                     return fmt::format("{},{},{},{}", p.ns / 1'000'000'000, p.ns % 1'000'000'000, p.place(","),
                                        p.xyzw(","));
                   }),
              1);
  const auto booted = with([](const Pose& p) { return fmt::format("{}", p.ns - kStart + 5'000'000'000); });
  ASSERT_TRUE(booted.ok()) << booted.error().line();
  EXPECT_EQ(booted->poses[1].stamp_ns, 5'050'000'000);
  EXPECT_NE(booted->note.find("ns"), std::string::npos);
  // Few whole seconds are seconds.
  const auto sparse = with([](const Pose& p) { return fmt::format("{}", (p.ns - kStart) / kStep * 60); });
  ASSERT_TRUE(sparse.ok()) << sparse.error().line();
  EXPECT_EQ(sparse->poses[1].stamp_ns, 60'000'000'000);
  EXPECT_EQ(sparse->note, "");
}

TEST(TrajectoryFormats, SemicolonsPartColumnsAndLeaveCommasForPoints) {
  const auto row = [](const Pose& p) { return p.seconds() + ";" + p.place(";") + ";" + p.xyzw(";"); };
  expect_path(read("t;x;y;z;qx;qy;qz;qw", row), 1);
  expect_path(read("", row), 1);
  expect_path(read("t;x;y;z;qx;qy;qz;qw",
                   [&](const Pose& p) {
                     std::string text = row(p);
                     std::replace(text.begin(), text.end(), '.', ',');
                     return text;
                   }),
              1);
}

TEST(TrajectoryFormats, VinsFusionIsOfTheImuAndHasWFirst) {
  const auto vins =
      read("", [](const Pose& p) { return fmt::format("{},{},{},0.1,0.2,0.3,", p.ns, p.place(","), p.wxyz(",")); });
  expect_path(vins, 1);
  EXPECT_TRUE(vins->of_body);
  EXPECT_EQ(vins->body, "the IMU (VINS-Fusion)");
}

TEST(TrajectoryFormats, KaistsPosesAreStampedAndOfTheVehicle) {
  const auto kaist = read("", [](const Pose& p) {
    const Eigen::Matrix3d R = p.q.toRotationMatrix();
    std::string out = fmt::format("{}", p.ns);
    for (int i = 0; i < 3; ++i) {
      fmt::format_to(std::back_inserter(out), ",{:.9f},{:.9f},{:.9f},{:.9f}", R(i, 0), R(i, 1), R(i, 2), p.t[i]);
    }
    return out;
  });
  expect_path(kaist, 1);
  EXPECT_TRUE(kaist->of_body);
  EXPECT_FALSE(kaist->numbered);
  EXPECT_EQ(kaist->mounting, BodyMounting::unknown);
}

TEST(TrajectoryFormats, TartanairsPosesAreARowAFrameInTheCamerasAxes) {
  // A camera that looks north, level: its optical axis is X there, its right is Y, down is Z.
  const auto tartan = read("", [](const Pose& p) { return p.place(" ") + " 0 0 0 1"; });
  ASSERT_TRUE(tartan.ok()) << tartan.error().line();
  EXPECT_EQ(tartan->format, TrajectoryFormat::kitti);
  EXPECT_NE(tartan->note.find("TartanAir"), std::string::npos);
  const Eigen::Matrix3d& R = tartan->poses[0].T_world_camera.R;
  EXPECT_LT((R.col(2) - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((R.col(0) - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_GT(R.determinant(), 0.0);
}

Eigen::Vector3d angles_of(const Eigen::Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), -std::asin(R(2, 0)), std::atan2(R(1, 0), R(0, 0))};
}

TEST(TrajectoryFormats, AnglesAreRollPitchYawOfAVehicle) {
  const Eigen::Matrix3d up = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const auto angles = [](const Pose& p, const char* between, double unit) {
    const Eigen::Vector3d a = angles_of(p.q.toRotationMatrix()) * unit;
    return fmt::format("{:.9f}{}{:.9f}{}{:.9f}", a.x(), between, a.y(), between, a.z());
  };
  const auto nclt = read(
      "", [&](const Pose& p) { return fmt::format("{}, {}, {}", p.ns / 1000, p.place(", "), angles(p, ", ", 1.0)); });
  expect_path(nclt, 1000, up);
  EXPECT_TRUE(nclt->of_body);
  const auto robotcar = read(
      "timestamp,latitude,longitude,altitude,northing,easting,down,utm_zone,velocity_north,velocity_east,"
      "velocity_down,roll,pitch,yaw",
      [&](const Pose& p) {
        return fmt::format("{},51.7,-1.2,110,{},30U,1,2,3,{}", p.ns / 1000, p.place(","), angles(p, ",", 1.0));
      });
  expect_path(robotcar, 1000, up);
  EXPECT_TRUE(robotcar->of_body);
  const auto degrees = read("time_ns x y z roll_deg pitch_deg yaw_deg", [&](const Pose& p) {
    return fmt::format("{} {} {}", p.ns, p.place(" "), angles(p, " ", 57.295779513082323));
  });
  expect_path(degrees, 1);
  EXPECT_TRUE(degrees->of_body);
  expect_error(read("t x y z roll pitch yaw", [](const Pose& p) { return p.seconds() + " 0 0 0 0 0 90"; }),
               ":2: an angle is more than a turn");
}

TEST(TrajectoryFormats, BoreasAnglesTurnTheOtherWayAndItsFileSaysOfWhat) {
  const std::string heading =
      "GPSTime,easting,northing,altitude,vel_east,vel_north,vel_up,roll,pitch,heading,angvel_z,angvel_y,angvel_x";
  const auto row = [](const Pose& p) {
    const Eigen::Vector3d a = angles_of(p.q.toRotationMatrix().transpose());
    return fmt::format("{},{},1,2,3,{:.9f},{:.9f},{:.9f},4,5,6", p.ns / 1000, p.place(","), a.x(), a.y(), a.z());
  };
  const auto camera = read(heading, row, "camera_poses.csv");
  expect_path(camera, 1000);
  EXPECT_FALSE(camera->of_body);
  const auto lidar = read(heading, row, "lidar_poses.csv");
  expect_path(lidar, 1000);
  EXPECT_TRUE(lidar->of_body);
}

TEST(TrajectoryFormats, ANumberOfFrameThatIsATimeIsOne) {
  const std::string heading =
      "# GNSS Poses\n# frame_id, translation_x, translation_y, translation_z, rotation_qx, rotation_qy, rotation_qz, "
      "rotation_w, scale, fusion_quality, v3";
  const auto row = [](const Pose& p, TimestampNs id) {
    return fmt::format("{},{},{},1.0,1,1", id, p.place(","), p.xyzw(","));
  };
  const auto stamped = read(heading, [&](const Pose& p) { return row(p, p.ns); });  // 4Seasons
  expect_path(stamped, 1);
  EXPECT_FALSE(stamped->of_body);
  const auto numbered = read(heading, [&](const Pose& p) { return row(p, (p.ns - kStart) / kStep + 3); });
  expect_path(numbered, 0);
  EXPECT_TRUE(numbered->numbered);
  EXPECT_EQ(numbered->poses[2].frame, 5);
}

TEST(TrajectoryFormats, WhatIsNoTableOfPosesIsRefusedInWords) {
  const auto positions = [](const Pose& p) { return fmt::format("{},{}", p.ns, p.place(",")); };
  expect_error(read("#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]", positions), "no orientation");
  expect_error(read("", positions), ":1: 4 words where a pose has ");
  expect_error(read("source_timestamp,destination_timestamp,x,y,z,roll,pitch,yaw",
                    [](const Pose& p) { return fmt::format("{},{},0.3,0,0,0,0,0.01", p.ns + kStep, p.ns); }),
               "motions from one time to another");
  const auto row = [](const Pose& p) { return p.seconds() + "," + p.place(",") + "," + p.xyzw(","); };
  expect_error(read("t,x,y,z,qx,qy,qz,qw,vx", row), ":2: 8 words where the heading names 9");
  expect_error(read("t,gt_x,y,x,qx,qy,qz,qw,z", [&](const Pose& p) { return row(p) + ",1"; }), "both be meant");
  for (const char* number : {"1e200", "nan", "inf", "-1e308", "x", ""}) {
    expect_error(
        read("t,x,y,z,qx,qy,qz,qw", [&](const Pose& p) { return p.seconds() + "," + number + ",0,0,0,0,0,1"; }),
        ":2: ");
    expect_error(read("t,x,y,z,qx,qy,qz,qw", [&](const Pose& p) { return p.seconds() + ",0,0,0,0,0,0," + number; }),
                 ":2: ");
    expect_error(read("t,x,y,z,qx,qy,qz,qw", [&](const Pose&) { return std::string(number) + ",0,0,0,0,0,0,1"; }),
                 ":2: ");
  }
}

TEST(TrajectoryFormats, ProseInCommentsChangesNothing) {
  for (const char* heading :
       {"# x y z are in m", "# ground truth of a drive\n# file: 'a.bag'\n# timestamp tx ty tz qx qy qz qw",
        "#timestamp, p_RS_R_x [m], ...", "# timestamp tx ty tz qx qy qz qw in seconds and metres"}) {
    SCOPED_TRACE(heading);
    expect_path(read(heading, tum), 1);
  }
}

}  // namespace
}  // namespace cliquevo::daemon
