// SPDX-License-Identifier: BSD-3-Clause
// One rig as the files of many programs have it, each in its own kind.
#include <algorithm>
#include <filesystem>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::list_of;
using test::write_file;

Eigen::Matrix4d matrix_of(const RigidTransform& T) {
  Eigen::Matrix4d out = Eigen::Matrix4d::Identity();
  out.topLeftCorner<3, 3>() = T.R;
  out.topRightCorner<3, 1>() = T.t;
  return out;
}

std::string flat(const RigidTransform& T) { return list_of(Eigen::MatrixXd(matrix_of(T))); }
std::string flat(const Eigen::MatrixXd& m) { return list_of(m); }

std::string four_of(const std::vector<double>& D) { return list_of(std::vector<double>(D.begin(), D.begin() + 4)); }

std::string intrinsics_of(const Eigen::Matrix3d& K) {
  return fmt::format("{}, {}, {}, {}", K(0, 0), K(1, 1), K(0, 2), K(1, 2));
}

// A body that is turned and moved against the left camera.
RigidTransform body() {
  RigidTransform T;
  T.R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.2, 0.9, -0.3).normalized()).toRotationMatrix();
  T.t = {0.3, -0.2, 0.1};
  return T;
}

// plumb_bob with four terms, as most of these programs have it.
test::Rig rig_of_four_terms() {
  test::Rig rig = test::make_rig();
  rig.D_left.back() = rig.D_right.back() = 0.0;
  return rig;
}

Result<StereoCalibration> read(const std::string& text, const std::string& name = "rig.yaml", int width = 640,
                               int height = 480) {
  return read_calibration(write_file(test::scratch_dir() + "/" + name, text), width, height);
}

void expect_rig(const Result<StereoCalibration>& c, const test::Rig& rig, double tolerance = 1e-6) {
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_NEAR(c->left.fx_px, rig.K_left(0, 0), 1e-3);
  EXPECT_NEAR(c->left.cy_px, rig.K_left(1, 2), 1e-3);
  EXPECT_NEAR(c->right.cx_px, rig.K_right(0, 2), 1e-3);
  EXPECT_NEAR(c->left.coefficients[0], rig.D_left[0], 1e-4);
  EXPECT_NEAR(c->right.coefficients[3], rig.D_right[3], 1e-4);
  EXPECT_LT((c->T_right_left.R - rig.T_right_left.R).norm(), tolerance);
  EXPECT_LT((c->T_right_left.t - rig.T_right_left.t).norm(), tolerance);
}

TEST(Ov2slam, HasBothCamerasBesideTheirPosesInTheBody) {
  const test::Rig rig = rig_of_four_terms();
  std::string text = "%YAML 1.0\n---\nCamera.model_left: pinhole\nCamera.model_right: pinhole\n";
  for (const char* side : {"left", "right"})
    text += fmt::format("Camera.{0}_nwidth: 640\nCamera.{0}_nheight: 480\n", side);
  for (const char side : {'l', 'r'}) {
    const Eigen::Matrix3d& K = side == 'l' ? rig.K_left : rig.K_right;
    const std::vector<double>& D = side == 'l' ? rig.D_left : rig.D_right;
    text += fmt::format("Camera.fx{0}: {1}\nCamera.fy{0}: {2}\nCamera.cx{0}: {3}\nCamera.cy{0}: {4}\n", side, K(0, 0),
                        K(1, 1), K(0, 2), K(1, 2));
    text += fmt::format("Camera.k1{0}: {1}\nCamera.k2{0}: {2}\nCamera.p1{0}: {3}\nCamera.p2{0}: {4}\n", side, D[0],
                        D[1], D[2], D[3]);
  }
  const RigidTransform T = body();
  const auto pose = [](int i, const RigidTransform& of) {
    return fmt::format("body_T_cam{}: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [{}]\n", i, flat(of));
  };
  expect_rig(read(text + pose(0, T) + pose(1, T * rig.T_right_left.inverse()) + "alpha: 0.\n"), rig);
}

TEST(PlSlam, NumberAroundBothCamerasIsTheRigs) {
  const test::Rig rig = rig_of_four_terms();
  const std::string cameras = fmt::format(
      "cam0:\n  Kl: [{}]\n  Kr: [{}]\n  Dl: [{}]\n  Dr: [{}]\n  cam_height: 480\n  cam_width: 640\n"
      "  cam_model: Pinhole\n",
      intrinsics_of(rig.K_left), intrinsics_of(rig.K_right), four_of(rig.D_left), four_of(rig.D_right));
  const std::string rectifications = fmt::format("  Rl: [{}]\n  Rr: [{}]\n", flat(rig.R1), flat(rig.R2));
  for (const char* key : {"t", "T"}) {
    const std::string pose =
        fmt::format("  R: [{}]\n  {}: [{}]\n", flat(rig.T_right_left.R), key, flat(rig.T_right_left.t));
    expect_rig(read(cameras + pose), rig);
    expect_rig(read(cameras + rectifications + pose), rig);
  }
}

TEST(Mrpt, ValuesHaveRemarksBehindThem) {
  const test::Rig rig = test::make_rig();
  const auto camera = [](const char* side, const Eigen::Matrix3d& K, std::vector<double> D) {
    return fmt::format(
        "[CAMERA_PARAMS_{}]\nresolution = [640 480]\ncx = {}\ncy = {}\nfx = {}\nfy = {}\n"
        "dist = [{} {} {} {} {}]    // The order is: [K1 K2 T1 T2 K3]\n",
        side, K(0, 2), K(1, 2), K(0, 0), K(1, 1), D[0], D[1], D[2], D[3], D[4]);
  };
  const RigidTransform T = rig.T_right_left.inverse();  // the right camera's pose in the left one
  const std::string pose = fmt::format(
      "[CAMERA_PARAMS_LEFT2RIGHT_POSE]\ntranslation_only = [{}]\nrotation_matrix_only = [{}]\n"
      "pose_quaternion = [0.1 0 0 1 0 0 0] // x y z qr qx qy qz\n",
      flat(T.t), flat(T.R));
  const std::string text = camera("LEFT", rig.K_left, rig.D_left) + camera("RIGHT", rig.K_right, rig.D_right) + pose;
  expect_rig(read(text, "camera_calib.ini"), rig);
  expect_rig(read(text, "camera_params.txt"), rig);
}

// DSEC's four cameras; cameras 1 and 2 are the rig, 0 and 3 beside them.
std::string dsec_yaml(const test::Rig& rig) {
  std::string text = "intrinsics:\n";
  for (int i = 0; i < 4; ++i) {
    const bool left = i < 2;
    const bool frame = i == 1 || i == 2;
    const char* size = frame ? "[640, 480]" : "[320, 240]";
    const Eigen::Matrix3d K = (left ? rig.K_left : rig.K_right) * (frame ? 1.0 : 0.5);
    text += fmt::format(
        "  cam{}:\n    camera_matrix: [{}]\n    distortion_coeffs: [{}]\n    distortion_model: radtan\n"
        "    resolution: {}\n",
        i, intrinsics_of(K), four_of(left ? rig.D_left : rig.D_right), size);
    const Eigen::Matrix3d P = rig.P1.topLeftCorner<3, 3>() * (frame ? 1.0 : 0.5);
    text += fmt::format("  camRect{}:\n    camera_matrix: [{}]\n    resolution: {}\n", i, intrinsics_of(P), size);
  }
  RigidTransform beside;
  beside.t = {-0.04, 0.0, 0.0};
  return text + fmt::format(
                    "extrinsics:\n  T_10: [{0}]\n  T_21: [{1}]\n  T_32: [{0}]\n  R_rect1: [{2}]\n"
                    "  R_rect2: [{3}]\n  R_rect0: [{4}]\n",
                    flat(beside), flat(rig.T_right_left), flat(rig.R1), flat(rig.R2),
                    flat(Eigen::Matrix3d(Eigen::Matrix3d::Identity())));
}

TEST(Dsec, FramesAreThePairOfTheirSizeWithTheFilesRectification) {
  test::Rig rig = rig_of_four_terms();
  const auto c = read(dsec_yaml(rig), "cam_to_cam.yaml");
  expect_rig(c, rig);
  ASSERT_TRUE(c->prescribed);
  EXPECT_NEAR(c->prescribed->model.fx_px, rig.P1(0, 0), 1e-6);
  EXPECT_NEAR(c->prescribed->model.baseline_m, rig.T_right_left.t.norm(), 1e-9);
  CalibrationOptions options;
  options.rectified = true;
  const std::string path = write_file(test::scratch_dir() + "/cam_to_cam.yaml", dsec_yaml(rig));
  const auto rectified = read_calibration(path, 640, 480, options);
  ASSERT_TRUE(rectified.ok()) << rectified.error().line();
  EXPECT_TRUE(rectified->rectified);
  EXPECT_NEAR(rectified->left.cx_px, rig.P1(0, 2), 1e-6);
}

TEST(Dsec, EventsAreTheOuterPairWithItsPosesOneAfterTheOther) {
  test::Rig rig = rig_of_four_terms();
  rig.T_right_left.R = rig.R1 = rig.R2 = Eigen::Matrix3d::Identity();
  rig.T_right_left.t = {-0.1, 0.0, 0.0};
  const auto c = read(dsec_yaml(rig), "cam_to_cam.yaml", 320, 240);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_NEAR(c->left.fx_px, 0.5 * rig.K_left(0, 0), 1e-6);
  EXPECT_NEAR(c->T_right_left.t.x(), -0.18, 1e-9);
}

std::string bouguet(const test::Rig& rig, const char* plus_minus) {
  const auto camera = [&](const char* side, const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format(
        "Intrinsic parameters of {0} camera:\n\n"
        "Focal Length:          fc_{0} = [ {1}   {2} ] {5} [ 1.13884   1.11887 ]\n"
        "Principal point:       cc_{0} = [ {3}   {4} ] {5} [ 2.05972   1.95312 ]\n"
        "Skew:             alpha_c_{0} = [ 0.00000 ] {5} [ 0.0 ]   => angle of pixel axes = 90.0 {5} 0.0 degrees\n"
        "Distortion:            kc_{0} = [ {6} ] {5} [ 0.01 0.01 0.01 0.01 0.01 ]\n\n",
        side, K(0, 0), K(1, 1), K(0, 2), K(1, 2), plus_minus, list_of(D));
  };
  const Eigen::AngleAxisd turn(rig.T_right_left.R);
  return "Stereo calibration parameters after optimization:\n\n\n" + camera("left", rig.K_left, rig.D_left) +
         camera("right", rig.K_right, rig.D_right) +
         fmt::format(
             "Extrinsic parameters (position of right camera wrt left camera):\n\n"
             "Rotation vector:             om = [ {} ] {} [ 0.003 0.003 0.0003 ]\n"
             "Translation vector:           T = [ {} ] {} [ 0.2 0.1 0.9 ]\n",
             flat(Eigen::Vector3d(turn.angle() * turn.axis())), plus_minus, flat(rig.T_right_left.t), plus_minus);
}

TEST(Bouguet, DeviationsStandBehindAnySign) {
  const test::Rig rig = test::make_rig();
  for (const char* sign : {"+-", "\xC2\xB1", "\xB1"}) expect_rig(read(bouguet(rig, sign), "calib.txt"), rig);
}

TEST(Matlab, ScriptWithRemarksIsFoundInAFolder) {
  const test::Rig rig = test::make_rig();
  const auto rows = [](const Eigen::Matrix3d& m) {
    std::string out;
    for (int r = 0; r < 3; ++r) out += fmt::format("{} {}   {} ;", m(r, 0), m(r, 1), m(r, 2));
    return out;
  };
  const std::string text = fmt::format(
      "KK_left = [{}];\nkc_left = [ {} ] ;\nKK_right = [{}];\nkc_right = [ {} ] ;\nR = [{}];\n"
      "T = [ {};   {};  {} ]; %% a column\n",
      rows(rig.K_left), list_of(rig.D_left), rows(rig.K_right), list_of(rig.D_right), rows(rig.T_right_left.R),
      rig.T_right_left.t.x(), rig.T_right_left.t.y(), rig.T_right_left.t.z());
  const std::string path = write_file(test::scratch_dir() + "/calib.m", text);
  EXPECT_EQ(find_calibration(std::filesystem::path(path).parent_path().string()), path);
  expect_rig(read_calibration(path, 640, 480), rig);
}

std::string airslam(const test::Rig& rig, const std::string& head, const std::string& per_camera, bool outwards) {
  const RigidTransform T_left = body();
  const RigidTransform T_right = T_left * rig.T_right_left.inverse();
  const auto camera = [&](int i, const Eigen::Matrix3d& K, const std::vector<double>& D, const RigidTransform& T) {
    return fmt::format("cam{}:\n  intrinsics: [{}]\n  distortion_coeffs: [{}, 0]\n{}  T: [{}]\n", i, intrinsics_of(K),
                       four_of(D), per_camera, flat(outwards ? T : T.inverse()));
  };
  return "image_height: 480\nimage_width: 640\n" + head + camera(0, rig.K_left, rig.D_left, T_left) +
         camera(1, rig.K_right, rig.D_right, T_right);
}

TEST(AirSlam, LensAndDirectionOfThePosesAreNumbers) {
  const test::Rig rig = rig_of_four_terms();
  const auto out = read(airslam(rig, "distortion_type: 1\n", "  T_type: 0\n", true));
  expect_rig(out, rig);
  EXPECT_EQ(out->left.distortion, Distortion::plumb_bob);
  const auto in = read(airslam(rig, "distortion_type: 2\n", "  T_type: 1\n", false));
  expect_rig(in, rig);
  EXPECT_EQ(in->left.distortion, Distortion::equidistant);
  const auto undistorted = read(airslam(rig, "distortion_type: 0\n", "  T_type: 1\n", false));
  ASSERT_TRUE(undistorted.ok()) << undistorted.error().line();
  EXPECT_EQ(undistorted->left.distortion, Distortion::none);
  const auto unknown = read(airslam(rig, "distortion_type: 7\n", "  T_type: 1\n", false));
  ASSERT_FALSE(unknown.ok());
  test::expect_clear(unknown.error(), {"distortion_type 7", "0 (undistorted)"});
}

TEST(AirSlam, WithoutADirectionTheRightCameraLiesOnTheRight) {
  const test::Rig rig = rig_of_four_terms();
  for (const bool outwards : {false, true}) {
    const auto c = read(airslam(rig, "", "  distortion_model: radtan\n", outwards));
    expect_rig(c, rig);
    ASSERT_EQ(c->notes.size(), 1U);
    EXPECT_NE(c->notes[0].find(outwards ? "taken for 0" : "taken for 1"), std::string::npos) << c->notes[0];
  }
}

TEST(Maplab, NcameraAmongOtherSensors) {
  const test::Rig rig = rig_of_four_terms();
  const auto camera = [](const Eigen::Matrix3d& K, const std::vector<double>& D, const RigidTransform& T) {
    return fmt::format(
        "      - camera:\n          id: 54812562fa109c40fe90b29a59dd7798\n          sensor_type: CAMERA\n"
        "          image_height: 480\n          image_width: 640\n          type: pinhole\n"
        "          intrinsics:\n            cols: 1\n            rows: 4\n            data: [{}]\n"
        "          distortion:\n            type: radtan\n            parameters:\n"
        "              cols: 1\n              rows: 4\n              data: [{}]\n"
        "        T_B_C:\n          cols: 4\n          rows: 4\n          data: [{}]\n",
        intrinsics_of(K), four_of(D), flat(T));
  };
  const RigidTransform T = body();
  expect_rig(read("sensors:\n  - id: 1\n    sensor_type: IMU\n  - id: 2\n    sensor_type: NCAMERA\n    cameras:\n" +
                  camera(rig.K_left, rig.D_left, T) + camera(rig.K_right, rig.D_right, T * rig.T_right_left.inverse())),
             rig);
}

TEST(Camodocal, CamerasOfAFolderBesideTheChainWithTheirPose) {
  const test::Rig rig = rig_of_four_terms();
  const std::string folder = test::scratch_dir();
  const auto camera = [&](int i, const Eigen::Matrix3d& K, const std::vector<double>& D) {
    write_file(fmt::format("{}/brand_gray{}.yaml", folder, i),
               fmt::format("%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: camera\nimage_width: 640\n"
                           "image_height: 480\ndistortion_parameters:\n   k1: {}\n   k2: {}\n   p1: {}\n   p2: {}\n"
                           "projection_parameters:\n   fx: {}\n   fy: {}\n   cx: {}\n   cy: {}\n",
                           D[0], D[1], D[2], D[3], K(0, 0), K(1, 1), K(0, 2), K(1, 2)));
  };
  camera(0, rig.K_left, rig.D_left);
  camera(1, rig.K_right, rig.D_right);
  write_file(folder + "/calib_chain.yaml",
             fmt::format("T_gray0_gray1: [{}]\nT_imu_gray0: [{}]\n", flat(rig.T_right_left.inverse()), flat(body())));
  EXPECT_EQ(find_calibration(folder), folder + "/brand_gray0.yaml");
  expect_rig(read_calibration(folder + "/brand_gray0.yaml", 640, 480), rig);
}

TEST(Keyed, PoseAsTheOnlyOneOfAList) {
  const test::Rig rig = test::make_rig();
  const auto camera = [](const char* name, const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format("{{\"id\":\"{}\",\"K\":[{}],\"D\":[{}]}}", name, flat(K), list_of(D));
  };
  const auto text = [&](double unit_m, const std::string& more) {
    return fmt::format(R"({{"cameras":[{},{}],"stereo":[{{"pair":"left_right","R":[{}],"T":[{}]{}}}]}})",
                       camera("left", rig.K_left, rig.D_left), camera("right", rig.K_right, rig.D_right),
                       flat(rig.T_right_left.R), flat(rig.T_right_left.t / unit_m), more);
  };
  expect_rig(read(text(1.0, ""), "rig.json"), rig);
  const double baseline_mm = 1000.0 * rig.T_right_left.t.norm();
  expect_rig(read(text(0.001, fmt::format(",\"baseline_mm\":{:.1f}", baseline_mm)), "rig.json"), rig);
}

bool notes_hold(const Result<StereoCalibration>& c, const std::string& fragment) {
  return c.ok() && std::any_of(c->notes.begin(), c->notes.end(),
                               [&](const std::string& note) { return note.find(fragment) != std::string::npos; });
}

// MC-Calib's file; `ending`: the last number of the camera matrices.
std::string mc_calib(const test::Rig& rig, bool right_first, double ending) {
  std::string text = "%YAML:1.0\n---\nnb_camera: 2\n";
  for (const int i : {0, 1}) {
    const bool left = (i == 0) != right_first;
    Eigen::Matrix3d K = left ? rig.K_left : rig.K_right;
    K(2, 2) = ending;
    const RigidTransform T_first_second = right_first ? rig.T_right_left : rig.T_right_left.inverse();
    text += fmt::format(
        "camera_{}:\n   camera_matrix: [{}]\n   distortion_vector: [{}]\n   distortion_type: 0\n"
        "   camera_group: 0\n   img_width: 640\n   img_height: 480\n   camera_pose_matrix: [{}]\n",
        i, flat(K), list_of(left ? rig.D_left : rig.D_right), flat(i == 0 ? RigidTransform{} : T_first_second));
  }
  return text;
}

TEST(McCalib, PoseIsTheCamerasInTheFirstOne) {
  const test::Rig rig = test::make_rig();
  const auto usual = read(mc_calib(rig, false, 1.0));
  expect_rig(usual, rig);
  EXPECT_TRUE(usual->notes.empty());
  const auto exchanged = read(mc_calib(rig, true, 1.0));
  expect_rig(exchanged, rig);
  EXPECT_TRUE(notes_hold(exchanged, "taken for the right camera"));
  EXPECT_TRUE(notes_hold(exchanged, "camera_pose_matrix is read as leading from the camera"));
}

TEST(McCalib, CameraMatrixThatEndsInZerosIsTakenAndTold) {
  const test::Rig rig = test::make_rig();
  const auto c = read(mc_calib(rig, false, 0.0));
  expect_rig(c, rig);
  EXPECT_TRUE(notes_hold(c, "end in 0 0 0"));
}

std::string two_cameras(const test::Rig& rig) {
  return fmt::format("image_width: 640\nimage_height: 480\nK1: [{}]\nD1: [{}]\nK2: [{}]\nD2: [{}]\n", flat(rig.K_left),
                     list_of(rig.D_left), flat(rig.K_right), list_of(rig.D_right));
}

TEST(Keyed, TransformAgainstItsNameIsTold) {
  const test::Rig rig = test::make_rig();
  const auto named = [&](const char* key, const RigidTransform& T) {
    return read(two_cameras(rig) + fmt::format("{}: [{}]\n", key, flat(T)));
  };
  for (const char* key : {"Stereo.T_c1_c2", "T_c2_c1"}) {
    const bool right_to_left = key[0] == 'S';
    const auto as_named = named(key, right_to_left ? rig.T_right_left.inverse() : rig.T_right_left);
    expect_rig(as_named, rig);
    EXPECT_TRUE(as_named->notes.empty());
    const auto against = named(key, right_to_left ? rig.T_right_left : rig.T_right_left.inverse());
    expect_rig(against, rig);
    EXPECT_TRUE(notes_hold(against, fmt::format("{} leads the other way", key)));
  }
}

TEST(Keyed, PosesOfPairsAmongThreeCamerasAreRefused) {
  const test::Rig rig = test::make_rig();
  const auto camera = [&](const char* name) {
    return fmt::format("{{\"id\":\"{}\",\"K\":[{}],\"D\":[{}]}}", name, flat(rig.K_left), list_of(rig.D_left));
  };
  const std::string pose = fmt::format(R"({{"R":[{}],"T":[{}]}})", flat(rig.T_right_left.R), flat(rig.T_right_left.t));
  const auto c = read(fmt::format(R"({{"cameras":[{},{},{}],"stereo":[{},{}]}})", camera("left"), camera("center"),
                                  camera("right"), pose, pose),
                      "rig.json");
  ASSERT_FALSE(c.ok());
  test::expect_clear(c.error(), {"of 3 cameras", "poses are of pairs"});
}

TEST(Keyed, OffsetsBetweenTheImagesAreNotIgnored) {
  const std::string text = "focal_px: 400\ncx: 320\ncy: 240\nbaseline_m: 0.3\n";
  for (const char* key : {"vertical_offset_px", "disparity_offset_px"}) {
    EXPECT_TRUE(read(text + key + ": 0.0\n").ok());
    const auto c = read(text + key + ": -33.0\n");
    ASSERT_FALSE(c.ok());
    test::expect_clear(c.error(), {"-33 px", key, "principal point"});
  }
}

TEST(Keyed, TomlIsFoundInAFolder) {
  const test::Rig rig = test::make_rig();
  const auto camera = [](int i, const Eigen::Matrix3d& K, const std::vector<double>& D, const RigidTransform& T) {
    const Eigen::AngleAxisd turn(T.R);
    return fmt::format(
        "[cam_{}]\nname = \"A\"\nsize = [ 640, 480,]\nmatrix = [{}]\ndistortions = [{},]\n"
        "rotation = [{}]\ntranslation = [{}]\n\n",
        i, flat(K), list_of(D), flat(Eigen::Vector3d(turn.angle() * turn.axis())), flat(T.t));
  };
  const std::string path = write_file(test::scratch_dir() + "/calibration.toml",
                                      camera(0, rig.K_left, rig.D_left, body().inverse()) +
                                          camera(1, rig.K_right, rig.D_right, rig.T_right_left * body().inverse()));
  EXPECT_EQ(find_calibration(std::filesystem::path(path).parent_path().string()), path);
  expect_rig(read_calibration(path, 640, 480), rig);
}

}  // namespace
}  // namespace cliquevo::drivers
