// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

// What the file of each format has: is_NAME() recognises a file, read_NAME() reads it.
#define CLIQUEVO_CALIBRATION_FORMAT(NAME)                                                               \
  bool is_##NAME(const CalibrationText& file);                                                          \
  Result<StereoCalibration> read_##NAME(const CalibrationText& file, const CalibrationRequest& request, \
                                        const OtherFile& other)

// Lines "key: numbers".
CLIQUEVO_CALIBRATION_FORMAT(kitti_odometry);  // P0, P1: rectified pinhole pairs
CLIQUEVO_CALIBRATION_FORMAT(kitti_raw);       // S_, K_, D_, R_, T_, S_rect_, R_rect_, P_rect_ of each camera's number
CLIQUEVO_CALIBRATION_FORMAT(middlebury);      // cam0=[f 0 cx; 0 f cy; 0 0 1], cam1, doffs, baseline in mm
// Five lines: "Pinhole|RadTan|EquiDistant fx fy cx cy [distortion]", absolute (px) or relative to the size; width and
// height; crop, full, none, or the output camera; its size; baseline in m. The cameras lie in parallel.
CLIQUEVO_CALIBRATION_FORMAT(dso);
// DSO's first lines in a file per camera (calib_0.txt, calib_1.txt), and a 4x4 matrix in calib_stereo.txt.
CLIQUEVO_CALIBRATION_FORMAT(four_seasons);
// Nine numbers of the camera matrix in a line, the baseline in the next: rectified pairs.
CLIQUEVO_CALIBRATION_FORMAT(foundation_stereo);
// A file per camera: fx fy cx cy, then a 4x4 matrix from the image's axes to the rig's; of undistorted images.
CLIQUEVO_CALIBRATION_FORMAT(robotcar);
// librealsense's rs-enumerate-devices -c: blocks of intrinsics by stream and size, poses between streams.
CLIQUEVO_CALIBRATION_FORMAT(realsense);
// Keys.
CLIQUEVO_CALIBRATION_FORMAT(kalibr);   // cam0, cam1: T_cn_cnm1 takes points from cam0 to cam1; T_cam_imu, T_imu_cam
CLIQUEVO_CALIBRATION_FORMAT(euroc);    // sensor.yaml of each camera: T_BS takes points of the camera to the body
CLIQUEVO_CALIBRATION_FORMAT(airslam);  // cam0, cam1: intrinsics, T with T_type; distortion_type by number
CLIQUEVO_CALIBRATION_FORMAT(dsec);     // intrinsics: cam0..3, camRect0..3; extrinsics: T_10, T_21, R_rect0
CLIQUEVO_CALIBRATION_FORMAT(maplab);   // sensors: an NCAMERA's cameras
CLIQUEVO_CALIBRATION_FORMAT(okvis);    // cameras: a list; T_SC takes points of the camera to the sensor
CLIQUEVO_CALIBRATION_FORMAT(vins);     // body_T_cam0, body_T_cam1, and a file of intrinsics per camera
CLIQUEVO_CALIBRATION_FORMAT(basalt);   // value0: T_imu_cam, intrinsics, resolution
CLIQUEVO_CALIBRATION_FORMAT(depthai);  // cameraData by socket; lengths in cm
CLIQUEVO_CALIBRATION_FORMAT(zed);      // [LEFT_CAM_VGA], ... and [STEREO]; lengths in mm
CLIQUEVO_CALIBRATION_FORMAT(ros);      // camera_info of each camera
#undef CLIQUEVO_CALIBRATION_FORMAT

std::span<const CalibrationFormat> calibration_formats() {
  // In the order in which a file is tried.
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
