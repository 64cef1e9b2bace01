// SPDX-License-Identifier: BSD-3-Clause
// What files of many people leave to the reader: units in names, sizes of boards, cameras in the other order, settings
// of another rig, matrices as transposes.
#include <array>

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

std::string line(const std::string& key, const std::string& numbers) { return fmt::format("{}: [{}]\n", key, numbers); }
std::string rows_of(const Eigen::MatrixXd& m) { return list_of(m); }

std::string cameras_of(const test::Rig& rig) {
  return "image_width: 640\nimage_height: 480\n" + line("K1", list_of(rig.K_left)) + line("D1", list_of(rig.D_left)) +
         line("K2", list_of(rig.K_right)) + line("D2", list_of(rig.D_right));
}

std::string pose_of(const RigidTransform& T, const std::string& key = "T", double unit_m = 1.0) {
  return line("R", rows_of(T.R)) + line(key, rows_of(T.t / unit_m));
}

Result<StereoCalibration> read(const std::string& text, const CalibrationOptions& options = {},
                               const std::string& name = "stereo.yml", int width = 640, int height = 480) {
  return read_calibration(write_file(test::scratch_dir() + "/" + name, text), width, height, options);
}

void expect_pose(const Result<StereoCalibration>& c, const RigidTransform& T, const std::string& what) {
  SCOPED_TRACE(what);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_LT((c->T_right_left.R - T.R).norm(), 1e-6);
  EXPECT_LT((c->T_right_left.t - T.t).norm(), 1e-6);
}

bool notes_hold(const Result<StereoCalibration>& c, const std::string& fragment) {
  for (const std::string& note : c->notes) {
    if (note.find(fragment) != std::string::npos) return true;
  }
  return false;
}

TEST(oddities, lengths_in_the_unit_that_their_name_tells) {
  const test::Rig rig = test::make_rig();
  const RigidTransform& T = rig.T_right_left;
  const std::string cameras = cameras_of(rig);
  expect_pose(read(cameras + pose_of(T, "translation_mm", 0.001)), T, "mm");
  expect_pose(read(cameras + pose_of(T, "T_cm", 0.01)), T, "cm");
  expect_pose(read(cameras + pose_of(T, "translation_m", 1.0)), T, "m");
  // By a baseline beside it.
  const double baseline_m = T.t.norm();
  const auto beside = read(cameras + pose_of(T, "T", 0.001) + fmt::format("baseline_cm: {:.4f}\n", 100.0 * baseline_m));
  expect_pose(beside, T, "baseline_cm");
  EXPECT_TRUE(notes_hold(beside, "baseline_cm"));
  // What the user says wins.
  CalibrationOptions options;
  options.baseline_unit_m = 0.01;
  const auto said = read(cameras + pose_of(T, "translation_mm", 0.01), options);
  expect_pose(said, T, "option");
  // Nominal values and errors are none.
  expect_pose(read(cameras + pose_of(T) + "expected_baseline_mm: 500\nbaseline_error_mm: 3\n"), T, "expected");
}

TEST(oddities, projections_in_the_unit_of_the_translation) {
  test::Rig rig = test::make_rig();
  rig.P2(0, 3) *= 1000.0;
  const std::string text = cameras_of(rig) + pose_of(rig.T_right_left, "translation_mm", 0.001) +
                           line("R1", rows_of(rig.R1)) + line("R2", rows_of(rig.R2)) + line("P1", rows_of(rig.P1)) +
                           line("P2", rows_of(rig.P2));
  const auto c = read(text);
  expect_pose(c, rig.T_right_left, "projections");
  ASSERT_TRUE(c->prescribed);
  EXPECT_NEAR(c->prescribed->model.baseline_m, rig.T_right_left.t.norm(), 1e-4);
}

TEST(oddities, a_baseline_alone_with_its_unit) {
  const std::string camera = "fx: 400\nfy: 400\ncx: 320\ncy: 240\n";
  for (const char* baseline : {"baseline_mm: 120", "baseline_cm: 12", "baseline: 120 mm", "baseline: 12cm",
                               "baseline_m: 0.12", "stereo:\n  baseline_mm: 120"}) {
    const auto c = read(camera + baseline + "\n");
    ASSERT_TRUE(c.ok()) << baseline << ": " << c.error().line();
    EXPECT_NEAR(c->T_right_left.t.x(), -0.12, 1e-9) << baseline;
  }
}

TEST(oddities, sizes_of_boards_and_windows_are_not_the_images) {
  const test::Rig rig = test::make_rig();
  const std::string text = cameras_of(rig) + pose_of(rig.T_right_left) +
                           "board_size: [9, 6]\nsquareSize: [30, 30]\nboard_width: 9\nboard_height: 6\n"
                           "chessboard:\n  cols: 9\n  rows: 6\ncamera_height_m: 1.2\n";
  const auto c = read(text);
  expect_pose(c, rig.T_right_left, "boards");
  EXPECT_EQ(c->left.width, 640);
}

TEST(oddities, strings_that_name_files_are_no_broken_matrices) {
  const test::Rig rig = test::make_rig();
  const std::string text =
      cameras_of(rig) + pose_of(rig.T_right_left) + "cam_pose_file: \"/home/me/pose.txt\"\nleft_K_topic: /left/k\n";
  expect_pose(read(text), rig.T_right_left, "files");
}

TEST(oddities, poses_of_each_camera_in_the_world_lead_either_way) {
  const test::Rig rig = test::make_rig();
  const RigidTransform left{so3_exp({0.3, -0.2, 0.1}), {0.4, 0.1, 1.0}};
  const RigidTransform right = rig.T_right_left * left;
  const auto both = [&](const char* R, const char* t, const RigidTransform& l, const RigidTransform& r) {
    return fmt::format("camera_0:\n  {0}: [{2}]\n  {1}: [{3}]\ncamera_1:\n  {0}: [{4}]\n  {1}: [{5}]\n", R, t,
                       rows_of(l.R), rows_of(l.t), rows_of(r.R), rows_of(r.t));
  };
  const std::string in = both("R_world_to_cam", "t_world_to_cam", left, right);
  const std::string out = both("R_cam_to_world", "t_cam_to_world", left.inverse(), right.inverse());
  const auto cameras = [&](const std::string& poses) {
    std::string text = poses;
    const auto add = [&](const char* key, const Eigen::Matrix3d& K, const std::vector<double>& D) {
      text.insert(text.find(key) + std::string(key).size(),
                  fmt::format("  camera_matrix: [{}]\n  dist_coeffs: [{}]\n", list_of(K), list_of(D)));
    };
    add("camera_0:\n", rig.K_left, rig.D_left);
    add("camera_1:\n", rig.K_right, rig.D_right);
    return text;
  };
  expect_pose(read(cameras(in)), rig.T_right_left, "into the cameras");
  expect_pose(read(cameras(out)), rig.T_right_left, "out of the cameras");
}

TEST(oddities, a_first_camera_that_lies_on_the_right_is_the_right_one) {
  test::Rig rig = test::make_rig();
  std::swap(rig.K_left, rig.K_right);
  std::swap(rig.D_left, rig.D_right);
  const RigidTransform exchanged = rig.T_right_left.inverse();
  const RigidTransform T = rig.T_right_left;
  // Poses that cannot be meant otherwise.
  rig.T_right_left = exchanged;
  const auto chain = read(test::kalibr_yaml(rig), {}, "camchain.yaml");
  expect_pose(chain, T, "chain");
  EXPECT_TRUE(notes_hold(chain, "taken for the right camera"));
  EXPECT_DOUBLE_EQ(chain->left.fx_px, rig.K_right(0, 0));
  // R and T alone may lead the other way.
  const auto open = read(cameras_of(rig) + pose_of(exchanged));
  ASSERT_FALSE(open.ok());
  test::expect_clear(open.error(),
                     {"right camera lies left", "exchange the cameras in the file", "turn R and T round"});
  // One and the same camera twice: only the sign is left.
  test::Rig twice = test::make_rig();
  twice.K_right = twice.K_left;
  twice.D_right = twice.D_left;
  const RigidTransform ideal{Eigen::Matrix3d::Identity(), {-0.1, 0.0, 0.0}};
  expect_pose(read(cameras_of(twice) + pose_of(ideal.inverse())), ideal, "ideal");
}

TEST(oddities, rectified_settings_beside_those_of_another_rig) {
  const test::Rig rig = test::make_rig();
  const auto side = [](const char* name, const Eigen::Matrix3d& K, const std::vector<double>& D,
                       const Eigen::Matrix3d& R, const Eigen::MatrixXd& P) {
    return fmt::format("{0}.width: 640\n{0}.height: 480\n", name) + line(std::string(name) + ".K", list_of(K)) +
           line(std::string(name) + ".D", list_of(D)) + line(std::string(name) + ".R", rows_of(R)) +
           line(std::string(name) + ".P", rows_of(P));
  };
  const std::string sides =
      side("LEFT", rig.K_left, rig.D_left, rig.R1, rig.P1) + side("RIGHT", rig.K_right, rig.D_right, rig.R2, rig.P2);
  const auto camera = [](double f, int width, int height) {
    return fmt::format(
        "%YAML:1.0\nCamera.fx: {0}\nCamera.fy: {0}\nCamera.cx: {1}\nCamera.cy: {2}\nCamera.bf: {3}\n"
        "Camera.width: {4}\nCamera.height: {5}\nViewer.PointSize:2\n",
        f, 0.5 * width, 0.5 * height, 0.075 * f, width, height);
  };
  const auto plain = read(camera(860.0, 1280, 720) + sides, {}, "orb.yaml", 1280, 720);
  ASSERT_TRUE(plain.ok()) << plain.error().line();
  EXPECT_TRUE(plain->rectified);
  EXPECT_NEAR(plain->prescribed->model.baseline_m, 0.075, 1e-9);
  EXPECT_NEAR(plain->prescribed->model.fx_px, 860.0, 1e-9);
  const auto raw = read(camera(860.0, 1280, 720) + sides, {}, "orb.yaml");
  expect_pose(raw, rig.T_right_left, "LEFT and RIGHT");
  const auto unclear = read(camera(860.0, 640, 480) + sides, {}, "orb.yaml");
  ASSERT_FALSE(unclear.ok());
  test::expect_clear(unclear.error(), {"two rectified cameras", "860.00 px", "leave LEFT and RIGHT out"});
  expect_pose(read(camera(rig.P1(0, 0), 640, 480) + sides, {}, "orb.yaml"), rig.T_right_left, "the same");
}

TEST(oddities, projections_without_a_baseline_take_it_from_bf) {
  const std::string side =
      "{0}.K: [336, 0, 336, 0, 336, 188, 0, 0, 1]\n{0}.R: [0, 0, 0, 0, 0, 0, 0, 0, 0]\n"
      "{0}.P: [336, 0, 336, 0, 0, 336, 188, 0, 0, 0, 1, 0]\n"
      "{0}.D: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data:[]\n";
  const auto c = read("%YAML:1.0\nCamera.fx: 336\nCamera.fy: 336\nCamera.cx: 336\nCamera.cy: 188\nCamera.bf: 12.0\n" +
                          fmt::format(fmt::runtime(side), "LEFT") + fmt::format(fmt::runtime(side), "RIGHT"),
                      {}, "airsim.yaml", 672, 376);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_NEAR(c->T_right_left.t.x(), -12.0 / 336.0, 1e-9);
}

TEST(oddities, mei_with_xi_beside_and_the_rotation_in_the_rectifications) {
  const test::Rig rig = test::make_rig();
  const auto D = [](const std::vector<double>& d) { return list_of(std::vector<double>(d.begin(), d.begin() + 4)); };
  const std::string text = line("Kl", list_of(rig.K_left)) + line("Dl", D(rig.D_left)) + "xil: 1.5\n" +
                           line("Rl", rows_of(rig.R1)) + line("Kr", list_of(rig.K_right)) + line("Dr", D(rig.D_right)) +
                           "xir: 1.6\n" + line("Rr", rows_of(rig.R2)) + line("T", rows_of(rig.T_right_left.t)) +
                           "cam_model: stereo\n";
  const auto c = read(text);
  expect_pose(c, rig.T_right_left, "mei");
  EXPECT_EQ(c->left.distortion, Distortion::unified);
  EXPECT_DOUBLE_EQ(c->left.coefficients[0], 1.5);
  EXPECT_DOUBLE_EQ(c->right.coefficients[0], 1.6);
  EXPECT_DOUBLE_EQ(c->right.coefficients[1], rig.D_right[0]);
}

TEST(oddities, transposes_are_read_as_what_they_are) {
  const test::Rig rig = test::make_rig();
  const RigidTransform& T = rig.T_right_left;
  const std::string matlab =
      line("K1", list_of(Eigen::Matrix3d(rig.K_left.transpose()))) + line("D1", list_of(rig.D_left)) +
      line("K2", list_of(Eigen::Matrix3d(rig.K_right.transpose()))) + line("D2", list_of(rig.D_right)) +
      line("R", rows_of(T.R.transpose())) + line("T", rows_of(T.t));
  const auto c = read(matlab);
  expect_pose(c, T, "matlab");
  EXPECT_DOUBLE_EQ(c->left.cx_px, rig.K_left(0, 2));
  EXPECT_TRUE(notes_hold(c, "MATLAB"));
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  pose.topLeftCorner<3, 3>() = T.R;
  pose.topRightCorner<3, 1>() = T.t;
  expect_pose(read(cameras_of(rig) + line("T_left_right", rows_of(pose.transpose()))), T, "4x4");
}

TEST(oddities, rotations_as_quaternions_of_either_order) {
  const test::Rig rig = test::make_rig();
  const RigidTransform& T = rig.T_right_left;
  const Eigen::Quaterniond q(T.R);
  const std::string cameras = cameras_of(rig) + line("T", rows_of(T.t));
  expect_pose(read(cameras + fmt::format("quaternion: [{}, {}, {}, {}]\n", q.x(), q.y(), q.z(), q.w())), T, "xyzw");
  expect_pose(read(cameras + fmt::format("rotation: [{}, {}, {}, {}]\n", q.w(), q.x(), q.y(), q.z())), T, "wxyz");
  expect_pose(read(cameras_of(rig) + fmt::format("extrinsics:\n  translation: {{x: {}, y: {}, z: {}}}\n"
                                                 "  rotation: {{w: {}, x: {}, y: {}, z: {}}}\n",
                                                 T.t.x(), T.t.y(), T.t.z(), q.w(), q.x(), q.y(), q.z())),
              T, "maps");
  const auto half = read(cameras + "quaternion: [0.5, 0.5, 0.5, 0.5]\n");
  ASSERT_FALSE(half.ok());
  test::expect_clear(half.error(), {"quaternion", "as a matrix"});
}

TEST(oddities, matrices_in_strings) {
  const test::Rig rig = test::make_rig();
  const auto text = [](const Eigen::MatrixXd& m) {
    std::string out;
    for (int r = 0; r < m.rows(); ++r) {
      out += r > 0 ? "]\\n [" : "[";
      for (int c = 0; c < m.cols(); ++c) out += fmt::format(" {}", m(r, c));
    }
    return "\"[" + out + "]]\"";
  };
  const Eigen::RowVectorXd D = Eigen::Map<const Eigen::RowVectorXd>(rig.D_left.data(), 5);
  const std::string json =
      fmt::format(R"({{"K1": {}, "D1": {}, "K2": {}, "D2": {}, "R": {}, "T": {}}})", text(rig.K_left), text(D),
                  text(rig.K_right), text(D), text(rig.T_right_left.R), text(rig.T_right_left.t.transpose()));
  expect_pose(read(json, {}, "calib.json"), rig.T_right_left, "strings");
}

TEST(oddities, both_images_side_by_side_in_the_size) {
  const test::Rig rig = test::make_rig();
  std::string text = cameras_of(rig) + pose_of(rig.T_right_left);
  text.replace(text.find("640"), 3, "1280");
  const auto c = read(text);
  expect_pose(c, rig.T_right_left, "side by side");
  EXPECT_EQ(c->left.width, 640);
  EXPECT_TRUE(notes_hold(c, "side by side"));
}

TEST(oddities, names_however_the_camera_is_written_to_them) {
  const test::Rig rig = test::make_rig();
  struct Names {
    const char* K;
    const char* D;
    const char* right_K;
    const char* right_D;
    const char* R;
    const char* T;
  };
  for (const Names& n : std::vector<Names>{
           {"leftcam_intrinsic", "leftcam_dist", "rightcam_intrinsic", "rightcam_dist", "R_relative", "T_relative"},
           {"KLEFT", "DLEFT", "KRIGHT", "DRIGHT", "R_lr", "T_lr"},
           {"LK", "LD", "RK", "RD", "Rstereo", "Tstereo"},
           {"KKL", "distl", "KKR", "distr", "Rlr", "Tlr"},
           {"A_izquierda", "dist_izquierda", "A_derecha", "dist_derecha", "Rs", "ts"},
           {"mtxLeft", "distLeft", "mtxRight", "distRight", "Extr_R", "Extr_T"}}) {
    const auto c = read("image_size: [640, 480]\n" + line(n.K, list_of(rig.K_left)) + line(n.D, list_of(rig.D_left)) +
                        line(n.right_K, list_of(rig.K_right)) + line(n.right_D, list_of(rig.D_right)) +
                        line(n.R, rows_of(rig.T_right_left.R)) + line(n.T, rows_of(rig.T_right_left.t)));
    expect_pose(c, rig.T_right_left, n.K);
    EXPECT_DOUBLE_EQ(c->left.fx_px, rig.K_left(0, 0)) << n.K;
    EXPECT_DOUBLE_EQ(c->right.fx_px, rig.K_right(0, 0)) << n.K;
  }
}

TEST(oddities, single_numbers_however_their_axis_is_written) {
  for (const auto& [x, y, u, v, baseline] : std::vector<std::array<const char*, 5>>{
           {"f_x", "f_y", "c_x", "c_y", "base_line"},
           {"focal_length_x", "focal_length_y", "principal_point_x", "principal_point_y", "baseline_length"},
           {"focalX", "focalY", "centerX", "centerY", "baseline_in_meters"},
           {"alpha_u", "alpha_v", "u0", "v0", "baseLine"}}) {
    const auto c = read(fmt::format("{}: 500.5\n{}: 500.5\n{}: 321\n{}: 243\n{}: 0.12\n", x, y, u, v, baseline));
    ASSERT_TRUE(c.ok()) << x << ": " << c.error().line();
    EXPECT_DOUBLE_EQ(c->left.fx_px, 500.5) << x;
    EXPECT_DOUBLE_EQ(c->left.cx_px, 321.0) << x;
    EXPECT_DOUBLE_EQ(c->left.cy_px, 243.0) << x;
    EXPECT_NEAR(c->T_right_left.t.norm(), 0.12, 1e-9) << x;
  }
}

TEST(oddities, baselines_between_wheels_or_antennas_are_not_the_cameras) {
  const std::string camera = "K: [500, 0, 320, 0, 500, 240, 0, 0, 1]\nwidth: 640\nheight: 480\n";
  for (const char* other : {"wheel_baseline: 0.28\n", "robot_baseline: 0.28\n", "wheel: {baseline: 0.28}\n",
                            "gnss_baseline: 1.1\n", "odom_baseline: 0.3\n"}) {
    const auto alone = read(camera + other);
    ASSERT_FALSE(alone.ok()) << other;
    test::expect_clear(alone.error(), {"calibration"});
    const auto beside = read(camera + "baseline: 0.12\ntrack_width: 0.3\n" + other);
    ASSERT_TRUE(beside.ok()) << other << beside.error().line();
    EXPECT_NEAR(beside->T_right_left.t.norm(), 0.12, 1e-9) << other;
  }
  const auto ours =
      read("visual_odometry:\n  camera:\n    fx: 500\n    fy: 500\n    cx: 320\n    cy: 240\n    baseline: 0.12\n");
  EXPECT_TRUE(ours.ok()) << ours.error().line();
}

TEST(oddities, cameras_in_lists_and_groups) {
  const test::Rig rig = test::make_rig();
  const std::string pose = line("R", rows_of(rig.T_right_left.R)) + line("T", rows_of(rig.T_right_left.t));
  const auto item = [](const std::string& name, const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format("  - {}\n    K: [{}]\n    D: [{}]\n", name, list_of(K), list_of(D));
  };
  const auto check = [&](const std::string& text) {
    const auto c = read("image_size: [640, 480]\n" + text);
    expect_pose(c, rig.T_right_left, text);
    EXPECT_DOUBLE_EQ(c->left.fx_px, rig.K_left(0, 0)) << text;
    EXPECT_DOUBLE_EQ(c->right.fx_px, rig.K_right(0, 0)) << text;
    EXPECT_DOUBLE_EQ(c->right.coefficients[0], rig.D_right[0]) << text;
  };
  for (const auto& [left, right] : std::vector<std::pair<std::string, std::string>>{
           {"name: left", "name: right"}, {"id: 0", "id: 1"}, {"camera_name: /cam/left", "camera_name: /cam/right"}}) {
    const std::string l = item(left, rig.K_left, rig.D_left);
    const std::string r = item(right, rig.K_right, rig.D_right);
    check("cameras:\n" + l + r + pose);
    check("cameras:\n" + r + l + pose);  // by name, not by order
  }
  for (const auto& [left, right] :
       std::vector<std::pair<std::string, std::string>>{{"l", "r"}, {"cameraL", "cameraR"}, {"L", "R"}}) {
    check("K:\n  " + line(left, list_of(rig.K_left)) + "  " + line(right, list_of(rig.K_right)) + "dist:\n  " +
          line(left, list_of(rig.D_left)) + "  " + line(right, list_of(rig.D_right)) + pose);
  }
  check(fmt::format("cam0:\n  intrinsics: [{}]\n  dist: [{}]\ncam1:\n  intrinsics: [{}]\n  dist: [{}]\n",
                    list_of(rig.K_left), list_of(rig.D_left), list_of(rig.K_right), list_of(rig.D_right)) +
        pose);
}

TEST(oddities, focal_lengths_and_principal_points_in_pairs) {
  const test::Rig rig = test::make_rig();
  const auto camera = [](const char* name, const Eigen::Matrix3d& K, const std::vector<double>& D) {
    return fmt::format("{}:\n  focal_length: [{}, {}]\n  principal_point: [{}, {}]\n  distortion: [{}]\n", name,
                       K(0, 0), K(1, 1), K(0, 2), K(1, 2), list_of(D));
  };
  const auto c = read(camera("left", rig.K_left, rig.D_left) + camera("right", rig.K_right, rig.D_right) +
                      pose_of(rig.T_right_left));
  expect_pose(c, rig.T_right_left, "pairs");
  EXPECT_DOUBLE_EQ(c->right.cy_px, rig.K_right(1, 2));
}

TEST(oddities, principal_points_that_cannot_be_of_the_size_beside_them) {
  test::Rig rig = test::make_rig();
  rig.K_left.block<2, 1>(0, 2) << 160.0, 120.0;
  rig.K_right.block<2, 1>(0, 2) << 165.0, 118.0;
  const auto small = read(cameras_of(rig) + pose_of(rig.T_right_left));
  ASSERT_FALSE(small.ok());
  test::expect_clear(small.error(), {"another image size than it says", "it says 640x480", "about 320x240"});
  rig.K_left(1, 2) = rig.K_right(1, 2) = 700.0;
  const auto off = read(cameras_of(rig) + pose_of(rig.T_right_left));
  ASSERT_FALSE(off.ok());
  test::expect_clear(off.error(), {"principal point", "off the image of 640x480"});
}

}  // namespace
}  // namespace cliquevo::drivers
