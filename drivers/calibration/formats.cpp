// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/formats.h"

namespace cliquevo::drivers {

std::span<const CalibrationFormat> calibration_formats() {
  static constexpr CalibrationFormat kFormats[] = {
      {"4Seasons", "calib_0.txt, calib_1.txt, calib_stereo.txt", is_four_seasons, read_four_seasons},
      {"KITTI raw", "S_00, K_00, R_rect_00, P_rect_00", is_kitti_raw, read_kitti_raw},
      {"KITTI odometry", "P0, P1", is_kitti_odometry, read_kitti_odometry},
      {"Middlebury", "cam0, cam1, doffs, baseline", is_middlebury, read_middlebury},
      {"FoundationStereo", "K of 9 numbers, baseline", is_foundation_stereo, read_foundation_stereo},
      {"RobotCar", "fx fy cx cy, 4x4 matrix", is_robotcar, read_robotcar},
      {"RealSense", "Intrinsic of \"Infrared 1\", Extrinsic from", is_realsense, read_realsense},
      {"ROS ost", "camera matrix, distortion, rectification, projection", is_ost, read_ost},
      {"ZED", "LEFT_CAM_HD, STEREO", is_zed, read_zed},
      {"VINS-Fusion", "body_T_cam0, body_T_cam1, cam0_calib", is_vins, read_vins},
      {"Basalt", "value0: T_imu_cam, intrinsics", is_basalt, read_basalt},
      {"DepthAI", "cameraData", is_depthai, read_depthai},
      {"OKVIS", "cameras: T_SC, focal_length", is_okvis, read_okvis},
      {"maplab", "sensors: NCAMERA", is_maplab, read_maplab},
      {"DSEC", "intrinsics: cam1, camRect1; extrinsics", is_dsec, read_dsec},
      {"AirSLAM", "cam0, cam1: intrinsics, T, T_type", is_airslam, read_airslam},
      {"Kalibr", "cam0, cam1: intrinsics, T_cn_cnm1", is_kalibr, read_kalibr},
      {"EuRoC", "T_BS, intrinsics", is_euroc, read_euroc},
      {"ROS camera_info", "camera_matrix, projection_matrix", is_ros, read_ros},
      {"OpenCV, ORB-SLAM, stella_vslam", "K1, D1, K2, D2, R, T; LEFT.K; Camera.fx, Camera.bf", is_keyed, read_keyed},
      {"DSO", "Pinhole, RadTan, EquiDistant", is_dso, read_dso},
  };
  return kFormats;
}

}  // namespace cliquevo::drivers
