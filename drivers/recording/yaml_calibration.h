// SPDX-License-Identifier: BSD-3-Clause
// Calibrations in YAML. Each has its own file; the right one is told by the keys.
#pragma once

#include "drivers/recording/calibration_common.h"
#include "drivers/recording/yaml_reader.h"

namespace cliquevo::drivers {

// EuRoC's sensor.yaml of each eye: T_BS (camera -> body), intrinsics, distortion, resolution.
Result<StereoCalibration> parse_euroc(const YamlReader& left, const YamlReader& right,
                                      const CalibrationRequest& request);
// Kalibr's camchain.yaml: cam0 is the left eye, cam1 the right one, cam1.T_cn_cnm1 takes points from cam0 to cam1.
Result<StereoCalibration> parse_kalibr(const YamlReader& chain, const CalibrationRequest& request);
// ROS camera_info of each eye, as camera_calibration writes it or as the message prints.
Result<StereoCalibration> parse_ros(const YamlReader& left, const YamlReader& right, const CalibrationRequest& request);
// What OpenCV's stereo calibration is written to with FileStorage: K1 (or M1), D1, K2, D2, R, T in m, and where present
// R1, R2, P1, P2. `extrinsics` is the same file, or the second of the two that the sample program writes.
Result<StereoCalibration> parse_opencv(const YamlReader& intrinsics, const YamlReader& extrinsics,
                                       const CalibrationRequest& request);

// Whether a file has the keys of ...
bool is_euroc(const YamlReader& yaml);
bool is_kalibr(const YamlReader& yaml);
bool is_ros(const YamlReader& yaml);
bool has_opencv_intrinsics(const YamlReader& yaml);
bool has_opencv_extrinsics(const YamlReader& yaml);

}  // namespace cliquevo::drivers
