// SPDX-License-Identifier: BSD-3-Clause
// One rig in the spellings of many programs and people: the words in a key count, not how they are joined.
#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::list_of;
using test::write_file;

std::string matrix(const std::string& key, int rows, int cols, const std::string& numbers) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n", key, rows, cols,
                     numbers);
}

struct Names {
  const char* K_left;
  const char* K_right;
  const char* D_left;
  const char* D_right;
  const char* R;
  const char* T;
};

std::string file_of(const test::Rig& rig, const Names& n) {
  return "%YAML:1.0\n---\n" + matrix(n.K_left, 3, 3, list_of(rig.K_left)) +
         matrix(n.D_left, 1, 5, list_of(rig.D_left)) + matrix(n.K_right, 3, 3, list_of(rig.K_right)) +
         matrix(n.D_right, 1, 5, list_of(rig.D_right)) +
         matrix(n.R, 3, 3, list_of(Eigen::MatrixXd(rig.T_right_left.R))) +
         matrix(n.T, 3, 1, list_of(Eigen::MatrixXd(rig.T_right_left.t)));
}

void expect_rig(const Result<StereoCalibration>& c, const test::Rig& rig, const std::string& what) {
  SCOPED_TRACE(what);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_DOUBLE_EQ(c->left.fx_px, rig.K_left(0, 0));
  EXPECT_DOUBLE_EQ(c->left.cy_px, rig.K_left(1, 2));
  EXPECT_DOUBLE_EQ(c->right.fy_px, rig.K_right(1, 1));
  EXPECT_DOUBLE_EQ(c->right.cx_px, rig.K_right(0, 2));
  EXPECT_DOUBLE_EQ(c->left.coefficients[0], rig.D_left[0]);
  EXPECT_DOUBLE_EQ(c->right.coefficients[1], rig.D_right[1]);
  EXPECT_LT((c->T_right_left.R - rig.T_right_left.R).norm(), 1e-6);
  EXPECT_LT((c->T_right_left.t - rig.T_right_left.t).norm(), 1e-6);
}

TEST(spellings, names_of_matrices_in_all_orders_and_joints) {
  const test::Rig rig = test::make_rig();
  const Names spellings[] = {
      {"cameraMatrixL", "cameraMatrixR", "distCoeffsL", "distCoeffsR", "R", "T"},
      {"KL", "KR", "DL", "DR", "R", "T"},
      {"mtx_l", "mtx_r", "dist_l", "dist_r", "rot", "trans"},
      {"left_K", "right_K", "left_D", "right_D", "R", "t"},
      {"camera_matrix_1", "camera_matrix_2", "dist_coeffs_1", "dist_coeffs_2", "rotation_matrix", "translation_vector"},
      {"M1", "M2", "D1", "D2", "R", "T"},
      {"K_0", "K_1", "dist_0", "dist_1", "Rot", "Trans"},
      {"Left_Camera_Matrix", "Right_Camera_Matrix", "Left_Distortion", "Right_Distortion", "Rotation", "Translation"},
      {"cameraMatrix1", "cameraMatrix2", "distCoeffs1", "distCoeffs2", "rotationMatrix", "translationVector"},
      {"intrinsicsLeft", "intrinsicsRight", "distortionLeft", "distortionRight", "R_left_right", "T_left_right"},
      {"cam0_intrinsic", "cam1_intrinsic", "cam0_distortion_coeffs", "cam1_distortion_coeffs", "stereo_R", "stereo_T"},
      {"LEFT.K", "RIGHT.K", "LEFT.D", "RIGHT.D", "Stereo.R", "Stereo.T"},
      {"leftCameraMatrix", "rightCameraMatrix", "leftDistCoeffs", "rightDistCoeffs", "R", "T"},
      {"K_l", "K_r", "D_l", "D_r", "R", "T"},
      {"intrinsic_matrix_left", "intrinsic_matrix_right", "distortion_left", "distortion_right", "R", "T"},
      {"mtxL", "mtxR", "distL", "distR", "R", "T"},
      {"camMatL", "camMatR", "distL", "distR", "Rot", "Trns"},
  };
  const std::string dir = test::scratch_dir();
  for (const Names& names : spellings) {
    expect_rig(read_calibration(write_file(dir + "/rig.yml", file_of(rig, names)), 640, 480), rig, names.K_left);
  }
}

TEST(spellings, values_right_behind_their_colons) {
  const test::Rig rig = test::make_rig();
  std::string text = file_of(rig, {"K1", "K2", "D1", "D2", "R", "T"});
  for (const char* key : {"rows", "cols", "dt", "data"}) {
    for (std::size_t at = text.find(std::string(key) + ": "); at != std::string::npos;
         at = text.find(std::string(key) + ": ")) {
      text.erase(at + std::string(key).size() + 1, 1);
    }
  }
  expect_rig(read_calibration(write_file(test::scratch_dir() + "/rig.yml", text), 640, 480), rig, text.substr(0, 80));
}

TEST(spellings, the_cameras_files_beside_the_one_with_their_pose) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const auto camera = [](const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return "%YAML:1.0\n---\n" + matrix("camera_matrix", 3, 3, list_of(K)) +
           matrix("distortion_coefficients", 1, 5, list_of(D));
  };
  const std::string pose = write_file(
      dir + "/stereo.yml", "%YAML:1.0\n---\n" + matrix("R", 3, 3, list_of(Eigen::MatrixXd(rig.T_right_left.R))) +
                               matrix("T", 3, 1, list_of(Eigen::MatrixXd(rig.T_right_left.t))));
  write_file(dir + "/left.yml", camera(rig.K_left, rig.D_left));
  const auto lacks = read_calibration(pose, 640, 480);
  ASSERT_FALSE(lacks.ok());
  test::expect_clear(lacks.error(), {"lacks the camera matrices", "left.yml and right.yml"});
  write_file(dir + "/right.yml", camera(rig.K_right, rig.D_right));
  expect_rig(read_calibration(dir, 640, 480), rig, "beside");
}

TEST(spellings, a_pair_of_files_counts_as_one_beside_their_pose) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  write_file(dir + "/rig_left.yaml", test::ros_yaml(rig, true));
  write_file(dir + "/rig_right.yaml", test::ros_yaml(rig, false));
  write_file(dir + "/rig_pose.yaml",
             "%YAML:1.0\n---\ncamera_name: rig\n" +
                 matrix("rotation_matrix", 3, 3, list_of(Eigen::MatrixXd(rig.T_right_left.R))) +
                 matrix("translation_matrix", 3, 1, list_of(Eigen::MatrixXd(rig.T_right_left.t))));
  EXPECT_EQ(find_calibration(dir), dir + "/rig_left.yaml");
}

TEST(spellings, maps_a_camera_in_yaml_and_json) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const auto rows = [](const Eigen::MatrixXd& m) {
    std::string out;
    for (int r = 0; r < m.rows(); ++r)
      out += fmt::format("{}[{}]", r > 0 ? ", " : "", list_of(Eigen::MatrixXd(m.row(r))));
    return "[" + out + "]";
  };
  const std::string yaml = fmt::format(
      "left:\n  camera_matrix: {}\n  distortion: [{}]\nright:\n  camera_matrix: {}\n  distortion: [{}]\n"
      "extrinsics:\n  R: {}\n  T: [{}]\nimage_size: [640, 480]\n",
      rows(rig.K_left), list_of(rig.D_left), rows(rig.K_right), list_of(rig.D_right), rows(rig.T_right_left.R),
      list_of(Eigen::MatrixXd(rig.T_right_left.t)));
  expect_rig(read_calibration(write_file(dir + "/rig.yaml", yaml), 640, 480), rig, "yaml");
  const std::string json = fmt::format(
      "{{\n\t\"K\": {{\"left\": {}, \"right\": {}}},\n\t\"dist\": {{\"left\": [{}], \"right\": [{}]}},\n\t\"R\": {},\n"
      "\t\"T\": [{}]\n}}\n",
      rows(rig.K_left), rows(rig.K_right), list_of(rig.D_left), list_of(rig.D_right), rows(rig.T_right_left.R),
      list_of(Eigen::MatrixXd(rig.T_right_left.t)));
  expect_rig(read_calibration(write_file(dir + "/rig.json", json), 640, 480), rig, "json");
}

TEST(spellings, a_rotation_vector_and_a_transform_serve_as_pose) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const std::string cameras = file_of(rig, {"K1", "K2", "D1", "D2", "unused_a", "unused_b"});
  const std::string vector = list_of(Eigen::MatrixXd(so3_log(rig.T_right_left.R)));
  expect_rig(
      read_calibration(write_file(dir + "/a.yml", cameras + matrix("om", 3, 1, vector) +
                                                      matrix("T", 3, 1, list_of(Eigen::MatrixXd(rig.T_right_left.t)))),
                       640, 480),
      rig, "rotation vector");
  for (const bool inverse : {false, true}) {
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    const RigidTransform pose = inverse ? rig.T_right_left.inverse() : rig.T_right_left;
    T.topLeftCorner<3, 3>() = pose.R;
    T.topRightCorner<3, 1>() = pose.t;
    expect_rig(
        read_calibration(write_file(dir + "/b.yml", cameras + matrix("T_left_right", 4, 4, list_of(T))), 640, 480), rig,
        inverse ? "inverse" : "transform");
  }
}

TEST(spellings, orb_slam_with_numbers_of_their_own) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const auto camera = [](const char* name, const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format(
        "{0}.fx: {1}\n{0}.fy: {2}\n{0}.cx: {3}\n{0}.cy: {4}\n{0}.k1: {5}\n{0}.k2: {6}\n{0}.p1: {7}\n"
        "{0}.p2: {8}\n",
        name, K(0, 0), K(1, 1), K(0, 2), K(1, 2), D[0], D[1], D[2], D[3]);
  };
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  const RigidTransform left_right = rig.T_right_left.inverse();
  T.topLeftCorner<3, 3>() = left_right.R;
  T.topRightCorner<3, 1>() = left_right.t;
  // ORB-SLAM3 before and after its file version 1.0.
  expect_rig(
      read_calibration(write_file(dir + "/a.yaml", "%YAML:1.0\n" + camera("Camera", rig.K_left, rig.D_left) +
                                                       camera("Camera2", rig.K_right, rig.D_right) +
                                                       "Camera.width: 640\nCamera.height: 480\nCamera.bf: 47.9\n" +
                                                       matrix("Tlr", 3, 4, list_of(T.topRows<3>()))),
                       640, 480),
      rig, "Tlr");
  expect_rig(read_calibration(write_file(dir + "/b.yaml", "%YAML:1.0\n" + camera("Camera1", rig.K_left, rig.D_left) +
                                                              camera("Camera2", rig.K_right, rig.D_right) +
                                                              "Camera.width: 640\nCamera.height: 480\n" +
                                                              matrix("Stereo.T_c1_c2", 4, 4, list_of(T))),
                              640, 480),
             rig, "T_c1_c2");
  // Rectified images: one camera and the baseline.
  for (const char* baseline : {"Camera.bf: 48.0", "Stereo.b: 0.12", "Camera.focal_x_baseline: 48.0"}) {
    const auto c = read_calibration(
        write_file(dir + "/c.yaml", fmt::format("%YAML:1.0\nCamera.type: \"PinHole\"\nCamera.fx: 400\nCamera.fy: 400\n"
                                                "Camera.cx: 320\nCamera.cy: 240\nCamera.k1: 0\nCamera.k2: 0\n"
                                                "Camera.p1: 0\nCamera.p2: 0\nThDepth: 35.0\n{}\n",
                                                baseline)),
        640, 480);
    ASSERT_TRUE(c.ok()) << c.error().line();
    EXPECT_TRUE(c->rectified);
    EXPECT_NEAR(c->prescribed->model.baseline_m, 0.12, 1e-9) << baseline;
  }
}

TEST(spellings, stella_vslam_rectifier) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const std::string camera = fmt::format(
      "fx: {0}\n  fy: {0}\n  cx: {1}\n  cy: {2}\n  focal_x_baseline: {3}\n  cols: 640\n"
      "  rows: 480\n  setup: stereo\n  model: perspective\n",
      rig.P1(0, 0), rig.P1(0, 2), rig.P1(1, 2), -rig.P2(0, 3));
  const std::string text = "Camera:\n  name: rig\n  " + camera +
                           fmt::format(
                               "StereoRectifier:\n  model: perspective\n  K_left: [{}]\n  D_left: [{}]\n  R_left: "
                               "[{}]\n  K_right: [{}]\n  D_right: [{}]\n  R_right: [{}]\n",
                               list_of(rig.K_left), list_of(rig.D_left), list_of(rig.R1), list_of(rig.K_right),
                               list_of(rig.D_right), list_of(rig.R2));
  const auto c = read_calibration(write_file(dir + "/stella.yaml", text), 640, 480);
  expect_rig(c, rig, "stella");
  ASSERT_TRUE(c->prescribed);
  EXPECT_NEAR(c->prescribed->model.fx_px, rig.P1(0, 0), 1e-9);
}

TEST(spellings, plain_lines_of_nobodys_format) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  for (const char* between : {": ", " = ", "="}) {
    const auto line = [&](const char* key, const std::string& numbers) {
      return fmt::format("{}{}[{}]\n", key, between, numbers);
    };
    const std::string text = line("K_left", list_of(rig.K_left)) + line("D_left", list_of(rig.D_left)) +
                             line("K_right", list_of(rig.K_right)) + line("D_right", list_of(rig.D_right)) +
                             line("R", list_of(Eigen::MatrixXd(rig.T_right_left.R))) +
                             line("T", list_of(Eigen::MatrixXd(rig.T_right_left.t)));
    expect_rig(read_calibration(write_file(dir + "/rig.txt", text), 640, 480), rig, between);
  }
}

TEST(spellings, a_fisheye_named_beside_the_rectified_perspective) {
  const std::string text =
      "Camera:\n  model: perspective\n  fx: 280\n  fy: 280\n  cx: 320\n  cy: 240\n  focal_x_baseline: 28\n"
      "StereoRectifier:\n  model: fisheye\n  K_left: [280, 0, 320, 0, 280, 240, 0, 0, 1]\n  D_left: [-0.003, 0.002, "
      "0.001, 0.0005]\n  R_left: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n  K_right: [280, 0, 320, 0, 280, 240, 0, 0, 1]\n"
      "  D_right: [-0.003, 0.002, 0.001, 0.0005]\n  R_right: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
  const auto c = read_calibration(write_file(test::scratch_dir() + "/stella.yaml", text), 640, 480);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_EQ(c->left.distortion, Distortion::equidistant);
  EXPECT_NEAR(c->prescribed->model.baseline_m, 0.1, 1e-9);
}

TEST(spellings, the_same_said_twice_and_differently_is_an_error) {
  test::Rig rig = test::make_rig();
  const std::string first = file_of(rig, {"K1", "K2", "D1", "D2", "R", "T"});
  rig.K_left(0, 0) += 5.0;
  const std::string path =
      write_file(test::scratch_dir() + "/stereo.yml", first + matrix("camera_matrix_left", 3, 3, list_of(rig.K_left)));
  const auto c = read_calibration(path, 640, 480);
  // Cameras by words beside cameras by numbers: distinguished, or an error.
  ASSERT_FALSE(c.ok());
  test::expect_clear(c.error(), {"twice", "camera_matrix_left"});
}

}  // namespace
}  // namespace cliquevo::drivers
