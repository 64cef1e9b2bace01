// SPDX-License-Identifier: BSD-3-Clause
// Calibrations as programs print them, and in more files than one.
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

void expect_rig(const Result<StereoCalibration>& c, const test::Rig& rig, double tolerance, const std::string& what) {
  SCOPED_TRACE(what);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_NEAR(c->left.fx_px, rig.K_left(0, 0), 1e-3);
  EXPECT_NEAR(c->right.cx_px, rig.K_right(0, 2), 1e-3);
  EXPECT_NEAR(c->right.coefficients[1], rig.D_right[1], tolerance);
  EXPECT_LT((c->T_right_left.R - rig.T_right_left.R).norm(), tolerance);
  EXPECT_LT((c->T_right_left.t - rig.T_right_left.t).norm(), tolerance);
}

// Rows in lines of their own, as numpy has them.
std::string printed(const Eigen::MatrixXd& m, const char* begin, const char* row_begin, const char* row_end,
                    const char* end) {
  std::string out = begin;
  for (int r = 0; r < m.rows(); ++r) {
    out += row_begin;
    for (int c = 0; c < m.cols(); ++c) out += fmt::format(" {:.9g}", m(r, c));
    out += row_end;
  }
  return out + end;
}

Eigen::MatrixXd row(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::RowVectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

std::string numpy(const std::string& name, const Eigen::MatrixXd& m) {
  return name + ":\n" + printed(m, " [", "[", "]\n ", "]\n");
}
std::string matlab(const std::string& name, const Eigen::MatrixXd& m) {
  return name + " =\n\n" + printed(m, "", "  ", "\n", "\n");
}
std::string titled(const std::string& name, const Eigen::MatrixXd& m) {
  return name + ":\n" + printed(m, "", "   ", "\n", "\n");
}

TEST(printed, by_numpy_by_matlab_and_under_titles) {
  const test::Rig rig = test::make_rig();
  const RigidTransform& T = rig.T_right_left;
  const std::string dir = test::scratch_dir();
  expect_rig(read_calibration(
                 write_file(dir + "/calib.txt", numpy("K_rgbL", rig.K_left) + numpy("D_rgbL", row(rig.D_left)) +
                                                    numpy("K_rgbR", rig.K_right) + numpy("D_rgbR", row(rig.D_right)) +
                                                    numpy("R", T.R) + numpy("T", T.t)),
                 640, 480),
             rig, 1e-6, "numpy");
  expect_rig(
      read_calibration(
          write_file(dir + "/stereoParams.txt",
                     matlab("intrinsicMatrix1", rig.K_left) + matlab("distortionCoefficients1", row(rig.D_left)) +
                         matlab("intrinsicMatrix2", rig.K_right) + matlab("distortionCoefficients2", row(rig.D_right)) +
                         matlab("rotationOfCamera2", T.R) + matlab("translationOfCamera2", T.t.transpose())),
          640, 480),
      rig, 1e-6, "matlab");
  expect_rig(
      read_calibration(
          write_file(dir + "/report.txt",
                     "=== STEREO CALIBRATION ===\n\n" + titled("LEFT CAMERA MATRIX", rig.K_left) +
                         titled("LEFT DISTORTION", row(rig.D_left)) + titled("RIGHT CAMERA MATRIX", rig.K_right) +
                         titled("RIGHT DISTORTION", row(rig.D_right)) + titled("ROTATION MATRIX (R)", T.R) +
                         titled("TRANSLATION VECTOR (T) [mm]", 1000.0 * T.t) +
                         "IMAGE SIZE (width x height):\n640 480\n\nRotation angles: -0.1, 2, 3\n"),
          640, 480),
      rig, 1e-6, "titles");
}

TEST(printed, by_bouguets_toolbox) {
  const test::Rig rig = test::make_rig();
  const RigidTransform& T = rig.T_right_left;
  const auto camera = [](const std::string& side, const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format(
        "Intrinsic parameters of {0} camera:\n\nFocal Length:          fc_{0} = [ {1}   {2} ] +- [ 0.8   0.8 ]\n"
        "Principal point:       cc_{0} = [ {3}   {4} ] +- [ 1.2   1.2 ]\n"
        "Skew:             alpha_c_{0} = [ 0.0 ] +- [ 0.0  ]   => angle of pixel axes = 90.0 +- 0.0 degrees\n"
        "Distortion:            kc_{0} = [ {5} ] +- [ 0.006   0.02   0.0002   0.0003  0.0 ]\n\n\n",
        side, K(0, 0), K(1, 1), K(0, 2), K(1, 2), fmt::join(D, "   "));
  };
  const Eigen::Vector3d om = so3_log(T.R);
  const auto text = [&](double unit_m) {
    const Eigen::Vector3d t = T.t / unit_m;
    return "Stereo calibration parameters after optimization:\n\n\n" + camera("left", rig.K_left, rig.D_left) +
           camera("right", rig.K_right, rig.D_right) +
           fmt::format(
               "Extrinsic parameters (position of right camera wrt left camera):\n\n"
               "Rotation vector:             om = [ {}   {}  {} ] +- [ 0.002   0.003  0.0002 ]\n"
               "Translation vector:           T = [ {}   {}   {} ] +- [ 0.1   0.1  0.4 ]\n",
               om.x(), om.y(), om.z(), t.x(), t.y(), t.z());
  };
  const std::string dir = test::scratch_dir();
  expect_rig(read_calibration(write_file(dir + "/Calib_Results_stereo.txt", text(1.0)), 640, 480), rig, 1e-6, "m");
  const auto mm = read_calibration(write_file(dir + "/Calib_Results_stereo.txt", text(0.001)), 640, 480);
  ASSERT_FALSE(mm.ok());
  test::expect_clear(mm.error(), {"implausible", "if in millimetres"});
}

std::string ost(const test::Rig& rig, bool left) {
  return fmt::format("# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n[narrow_stereo/{}]\n\n",
                     left ? "left" : "right") +
         "camera matrix\n" + printed(left ? rig.K_left : rig.K_right, "", "", "\n", "\n") + "distortion\n" +
         printed(row(left ? rig.D_left : rig.D_right), "", "", "\n", "\n") + "rectification\n" +
         printed(left ? rig.R1 : rig.R2, "", "", "\n", "\n") + "projection\n" +
         printed(left ? rig.P1 : rig.P2, "", "", "\n", "\n");
}

TEST(printed, by_the_ros_calibrator_twice_and_in_a_file_that_is_named_yaml) {
  const test::Rig rig = test::make_rig();
  const std::string once = "Left:\n('D = ', [-0.3, 0.1, 0.0, 0.0, 0.0])\nNone\n" + ost(rig, true) + ost(rig, false);
  for (const char* name : {"/calibration.yaml", "/calibration.txt"}) {
    const std::string path = write_file(
        test::scratch_dir() + name, once + "\n('Wrote calibration data to', '/tmp/calibrationdata.tar.gz')\n\n" + once);
    expect_rig(read_calibration(path, 640, 480), rig, 1e-6, name);
  }
}

std::string one_camera(const Eigen::Matrix3d& K, const std::vector<double>& D, const RigidTransform& T) {
  return fmt::format("K: [{}]\ncoeffs: [{}]\nR: [{}]\nt: [{}]\nimageSize: [640, 480]\n", list_of(K), list_of(D),
                     list_of(Eigen::MatrixXd(T.R)), list_of(Eigen::MatrixXd(T.t)));
}

TEST(files_of_each_camera, with_their_poses_in_them) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  write_file(dir + "/cam1.yml", one_camera(rig.K_left, rig.D_left, {}));
  write_file(dir + "/cam2.yml", one_camera(rig.K_right, rig.D_right, rig.T_right_left));
  for (const char* name : {"/cam1.yml", "/cam2.yml", ""}) {
    expect_rig(read_calibration(dir + name, 640, 480), rig, 1e-6, name);
  }
}

TEST(files_of_each_camera, with_their_pose_in_a_third_file_or_none) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const auto camera = [](const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format("camera_matrix: [{}]\ndist_coeffs: [{}]\n", list_of(K), list_of(D));
  };
  const std::string left = write_file(dir + "/calib_l.yaml", camera(rig.K_left, rig.D_left));
  const auto single = read_calibration(left, 640, 480);
  ASSERT_FALSE(single.ok());
  test::expect_clear(single.error(), {"single camera", "calib_l.yaml"});
  write_file(dir + "/calib_r.yaml", camera(rig.K_right, rig.D_right));
  const auto pair = read_calibration(left, 640, 480);
  ASSERT_FALSE(pair.ok());
  test::expect_clear(pair.error(), {"lacks R and T", "stereo.yml"});
  write_file(dir + "/stereo.yaml", fmt::format("R: [{}]\nT: [{}]\n", list_of(Eigen::MatrixXd(rig.T_right_left.R)),
                                               list_of(Eigen::MatrixXd(rig.T_right_left.t))));
  expect_rig(read_calibration(left, 640, 480), rig, 1e-6, "three files");
}

TEST(files_of_each_camera, whatever_else_their_names_hold) {
  const test::Rig rig = test::make_rig();
  for (const auto& [left, right] : std::vector<std::pair<std::string, std::string>>{
           {"/15201_left.yml", "/15202_right.yml"}, {"/l.yml", "/r.yml"}, {"/sensor0.yml", "/sensor1.yml"}}) {
    const std::string dir = test::scratch_dir();
    write_file(dir + left, one_camera(rig.K_left, rig.D_left, {}));
    write_file(dir + right, one_camera(rig.K_right, rig.D_right, rig.T_right_left));
    for (const std::string& name : {left, right, std::string()}) {
      expect_rig(read_calibration(dir + name, 640, 480), rig, 1e-6, left);
    }
  }
}

TEST(files_of_each_camera, with_their_pose_as_numbers_by_name) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const auto camera = [](const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format("camera_matrix: [{}]\ndist_coeffs: [{}]\n", list_of(K), list_of(D));
  };
  const std::string left = write_file(dir + "/camera_left.yaml", camera(rig.K_left, rig.D_left));
  write_file(dir + "/camera_right.yaml", camera(rig.K_right, rig.D_right));
  const Eigen::Quaterniond q(rig.T_right_left.R);
  const Eigen::Vector3d t = rig.T_right_left.t;
  write_file(dir + "/extrinsics.yaml",
             fmt::format("transform:\n  q_x: {}\n  q_y: {}\n  q_z: {}\n  q_w: {}\n  t_x: {}\n  t_y: {}\n  t_z: {}\n",
                         q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()));
  expect_rig(read_calibration(left, 640, 480), rig, 1e-6, "quaternion");
}

TEST(files_of_each_camera, settings_of_openvins_name_the_chain) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const auto camera = [](const char* name, const std::string& pose, const Eigen::Matrix3d& K,
                         const std::vector<double>& D) {
    return fmt::format(
        "{}:\n{}  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [{}, {}, {}, {}]\n"
        "  intrinsics: [{}, {}, {}, {}]\n  resolution: [640, 480]\n",
        name, pose, D[0], D[1], D[2], D[3], K(0, 0), K(1, 1), K(0, 2), K(1, 2));
  };
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> T;  // without its last row
  T << rig.T_right_left.R, rig.T_right_left.t;
  write_file(dir + "/chain.yaml", camera("cam0", "", rig.K_left, rig.D_left) +
                                      camera("cam1", fmt::format("  T_cn_cnm1: [{}]\n", list_of(Eigen::MatrixXd(T))),
                                             rig.K_right, rig.D_right));
  const std::string path =
      write_file(dir + "/estimator_config.yaml", "use_stereo: true\nrelative_config_imucam: \"chain.yaml\"\n");
  const auto c = read_calibration(path, 640, 480);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_DOUBLE_EQ(c->left.fx_px, rig.K_left(0, 0));
  EXPECT_LT((c->T_right_left.t - rig.T_right_left.t).norm(), 1e-9);
}

TEST(bare_numbers, foundation_stereo) {
  const std::string path = write_file(test::scratch_dir() + "/K.txt", "750.5 0 480.25 0 750.5 270.75 0 0 1\n0.063\n");
  const auto c = read_calibration(path, 960, 540);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_TRUE(c->rectified);
  EXPECT_DOUBLE_EQ(c->prescribed->model.fx_px, 750.5);
  EXPECT_DOUBLE_EQ(c->prescribed->model.baseline_m, 0.063);
}

// As `rs-enumerate-devices -c` prints it: two sizes of each stream, and other streams between them.
std::string realsense_text(const std::string& stream, const std::string& lens, const std::string& rotation) {
  const auto block = [&](const std::string& name, int width, int height, double f) {
    return fmt::format(
        " Intrinsic of \"{}\" / {}x{} / {{Y8}}\n  Width:      \t{}\n  Height:     \t{}\n  PPX:        \t{}\n"
        "  PPY:        \t{}\n  Fx:         \t{}\n  Fy:         \t{}\n  {}\n  FOV (deg):  \t79.58 x 63.98\n\n",
        name, width, height, width, height, 0.5 * width - 0.25, 0.5 * height + 1.5, f, f, lens);
  };
  std::string text =
      "Device info: \n    Name                          : \tIntel RealSense D435I\n\nIntrinsic Parameters:\n\n";
  for (const std::string& name : {std::string("Depth"), stream + " 1", stream + " 2", std::string("Color")}) {
    text += block(name, 848, 480, 424.5) + block(name, 640, 480, 384.25);
  }
  text += "Extrinsic Parameters:\n";
  for (const char* to : {" 1", " 2"}) {
    text += fmt::format(
        "Extrinsic from \"{} 1\"\t  To\t  \"{}{}\" :\n Rotation Matrix:\n{}\n Translation Vector: {}  0.0001  0  \n\n",
        stream, stream, to, rotation, to[1] == '1' ? 0.0 : -0.0501);
  }
  return text;
}

constexpr char kUnturned[] =
    "   1                0                0            \n   0                1                0\n   0 0 1\n";

TEST(realsense, infrared_streams_are_chosen_by_the_size_of_the_images) {
  const std::string path = write_file(
      test::scratch_dir() + "/camera.txt",
      realsense_text("Infrared", "Distortion: \tBrown Conrady\n  Coeffs:     \t0  \t0  \t0  \t0  \t0", kUnturned));
  for (const auto& [width, f] : {std::pair{848, 424.5}, {640, 384.25}}) {
    const auto c = read_calibration(path, width, 480);
    ASSERT_TRUE(c.ok()) << c.error().line();
    EXPECT_DOUBLE_EQ(c->left.fx_px, f);
    EXPECT_DOUBLE_EQ(c->left.cx_px, 0.5 * width - 0.25);
    EXPECT_EQ(c->right.distortion, Distortion::none);
    EXPECT_DOUBLE_EQ(c->T_right_left.t.x(), -0.0501);
  }
  const auto other = read_calibration(path, 500, 500);
  ASSERT_FALSE(other.ok());
  test::expect_clear(other.error(), {"\"Infrared 1\"", "500x500", "848x480, 640x480"});
}

TEST(realsense, fisheyes_keep_their_lens_and_their_turn) {
  const std::string path = write_file(
      test::scratch_dir() + "/t265.txt",
      realsense_text("Fisheye",
                     "Distortion: \tKannala Brandt4\n  Coeffs:     \t-0.0052  \t0.0402  \t-0.0371  \t0.0062  \t0",
                     "   0.999995         0.00241        -0.00190\n  -0.00241          0.999997         0.0000\n   "
                     "0.00190          0.0000           0.999998\n"));
  const auto c = read_calibration(path, 848, 480);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_EQ(c->left.distortion, Distortion::equidistant);
  EXPECT_DOUBLE_EQ(c->left.coefficients[1], 0.0402);
  EXPECT_NEAR(c->T_right_left.R(0, 1), 0.00241, 1e-6);
}

TEST(realsense, a_text_that_is_cut_off_is_named) {
  const std::string whole =
      realsense_text("Infrared", "Distortion: \tBrown Conrady\n  Coeffs:     \t0  \t0  \t0  \t0  \t0", kUnturned);
  const std::string path = test::scratch_dir() + "/torn.txt";
  for (const char* end : {"Extrinsic Parameters", "Intrinsic of \"Infrared 2\"", " Translation Vector: -0.0501"}) {
    write_file(path, whole.substr(0, whole.find(end)));
    const auto c = read_calibration(path, 640, 480);
    ASSERT_FALSE(c.ok()) << end;
    test::expect_clear(c.error(), {"torn.txt", "rs-enumerate-devices"});
  }
}

TEST(bare_numbers, robotcar_camera_models) {
  const std::string dir = test::scratch_dir();
  const auto model = [](double y) {
    return fmt::format("980.5 980.5 640.25 490.75\n0 0 1 0\n1 0 0 {}\n0 1 0 0\n0 0 0 1\n", y);
  };
  write_file(dir + "/stereo_wide_left.txt", model(0.0));
  write_file(dir + "/stereo_wide_right.txt", model(0.24));
  for (const char* name : {"/stereo_wide_left.txt", "/stereo_wide_right.txt"}) {
    const auto c = read_calibration(dir + name, 1280, 960);
    ASSERT_TRUE(c.ok()) << c.error().line();
    EXPECT_NEAR(c->prescribed->model.baseline_m, 0.24, 1e-12);
    EXPECT_DOUBLE_EQ(c->prescribed->model.cx_px, 640.25);
  }
}

}  // namespace
}  // namespace cliquevo::drivers
