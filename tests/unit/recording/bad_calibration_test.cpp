// SPDX-License-Identifier: BSD-3-Clause
// A calibration that is wrong is an error that states what, where and what to do.
#include <filesystem>

#include <fmt/format.h>

#include "drivers/calibration_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::write_file;

std::string replace(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

void expect_bad(const std::string& path, const std::vector<std::string>& fragments, int width = 0, int height = 0) {
  const auto c = read_calibration(path, width, height);
  ASSERT_FALSE(c.ok()) << path;
  test::expect_clear(c.error(), fragments);
}

void expect_bad_text(const std::string& name, const std::string& text, const std::vector<std::string>& fragments,
                     int width = 0, int height = 0) {
  std::vector<std::string> all = fragments;
  all.push_back(name);
  expect_bad(write_file(test::scratch_dir() + "/" + name, text), all, width, height);
}

TEST(bad_calibration, file_that_is_missing_empty_binary_or_no_file) {
  const std::string dir = test::scratch_dir();
  expect_bad(dir + "/none.txt", {"none.txt", "no calibration"});
  expect_bad(dir, {"folder holds no calibration", dir});
  expect_bad_text("calib.txt", "", {"empty"});
  expect_bad_text("calib.txt", "\n\n# nothing\n", {"empty"});
  expect_bad_text("calib.txt", std::string("P0: 1 2\0 3", 10), {"NUL"});
  expect_bad_text("calib.yaml", std::string("K1: \0", 5), {"NUL"});
  expect_bad_text("calib.txt", std::string(3 << 20, ' '), {"too big"});
  expect_bad("/dev/zero", {"/dev/zero", "regular file"});
}

TEST(bad_calibration, file_of_no_known_format) {
  expect_bad_text("calib.txt", "hello world\n", {"no known format", ":1"});
  expect_bad_text("calib.txt", "1 2 3\n", {"no known format"});
  expect_bad_text("calib.yaml", "a: 1\nb: [2, 3]\n", {"no known format"});
  expect_bad_text("calib.yaml", "- 1\n- 2\n", {"no known format"});
  expect_bad_text("calib.yaml", "K1: [1, 2\nb: }", {"no valid YAML"});
  expect_bad_text("calib.yaml", "\x7f\x45\x4c\x46\x02\x01\x01", {"calib.yaml"});
  expect_bad_text("calib.yaml", std::string(5000, '['), {"no valid YAML"});
}

TEST(bad_calibration, of_another_size_names_both_sizes) {
  const test::Rig rig = test::make_rig();
  const std::vector<std::string> sizes{"another image size", "640x480", "320x200"};
  expect_bad_text("camchain.yaml", test::kalibr_yaml(rig), sizes, 320, 200);
  expect_bad_text("stereo.yml", test::opencv_yaml(rig, true), sizes, 320, 200);
  expect_bad_text("calib_cam_to_cam.txt", test::kitti_raw_txt(rig), sizes, 320, 200);
  expect_bad_text("camera.txt", "Pinhole 300 300 320 240 0\n640 480\ncrop\n640 480\n0.12\n", sizes, 320, 200);
  const std::string dir = test::scratch_dir();
  write_file(dir + "/left.yaml", test::ros_yaml(rig, true));
  write_file(dir + "/right.yaml", test::ros_yaml(rig, false));
  expect_bad(dir + "/left.yaml", sizes, 320, 200);
  write_file(dir + "/cam0/sensor.yaml", test::euroc_yaml(rig, true));
  write_file(dir + "/cam1/sensor.yaml", test::euroc_yaml(rig, false));
  expect_bad(dir + "/cam0/sensor.yaml", sizes, 320, 200);
}

TEST(bad_calibration, of_another_size_is_found_where_the_file_tells_none) {
  const std::string text = test::kitti_calibration(100.0, 31.5, 31.5, 0.5);  // for 64x48
  const std::vector<std::string> sizes{"another image size", "about 63x47"};
  expect_bad_text("calib.txt", text, sizes, 34, 48);
  expect_bad_text("calib.txt", text, sizes, 110, 83);  // by a factor that no camera has
  // Cropped in height, as recordings of roads are: not another size.
  const std::string path = write_file(test::scratch_dir() + "/calib.txt", text);
  EXPECT_TRUE(read_calibration(path, 64, 26).ok());
  EXPECT_TRUE(read_calibration(path, 64, 96).ok());
}

TEST(bad_calibration, with_cameras_of_unequal_size) {
  test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  write_file(dir + "/left.yaml", test::ros_yaml(rig, true));
  rig.width = 800;
  write_file(dir + "/right.yaml", test::ros_yaml(rig, false));
  expect_bad(dir + "/left.yaml", {"unequal sizes", "640x480", "800x480"});
}

TEST(bad_calibration, with_the_other_camera_missing) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  expect_bad(write_file(dir + "/left.yaml", test::ros_yaml(rig, true)), {"other camera is missing", "right.yaml"});
  expect_bad(write_file(dir + "/cam0/sensor.yaml", test::euroc_yaml(rig, true)), {"other camera", "cam1/sensor.yaml"});
  const std::string kalibr = test::kalibr_yaml(rig);
  expect_bad_text("camchain.yaml", kalibr.substr(0, kalibr.find("cam1:")), {"lacks cam1"});
  expect_bad_text("calib.txt", "P0: 100 0 31 0 0 100 23 0 0 0 1 0\n", {"lacks P1"});
}

TEST(bad_calibration, that_is_singular_or_absurd) {
  expect_bad_text("calib.txt", test::kitti_calibration(0.0), {"singular", "P0"}, 64, 48);
  expect_bad_text("calib.txt", test::kitti_calibration(-100.0), {"singular", "P0"}, 64, 48);
  expect_bad_text("calib.txt", test::kitti_calibration(1e7), {"focal length"}, 64, 48);
  expect_bad_text("calib.txt", test::kitti_calibration(1e-3), {"focal length"}, 64, 48);
  expect_bad_text("calib.txt", test::kitti_calibration(100.0, 1e6, 1e6), {"principal point"}, 64, 48);
  expect_bad_text("calib.txt", test::kitti_calibration(100.0, 31.5, 31.5, 0.0), {"baseline is zero"}, 64, 48);
  expect_bad_text("calib.txt", test::kitti_calibration(100.0, 31.5, 31.5, -0.5), {"swapped"}, 64, 48);
  expect_bad_text("calib.txt", test::kitti_calibration(100.0, 31.5, 31.5, 120.0), {"baseline of 120 m", "millimetres"},
                  64, 48);
  const std::string skewed = replace(test::kitti_raw_txt(test::make_rig()), "K_00: 458.654  0", "K_00: 458.654  458");
  expect_bad_text("calib_cam_to_cam.txt", skewed, {"not that of a pinhole camera", "K_00"});
  test::Rig rig = test::make_rig();
  rig.T_right_left.R.setZero();
  expect_bad_text("camchain.yaml", test::kalibr_yaml(rig), {"no rotation"});
  expect_bad_text("stereo.yml", test::opencv_yaml(rig, false), {"no rotation"});
  expect_bad_text("calib_cam_to_cam.txt", test::kitti_raw_txt(rig), {"no rotation"});
  rig = test::make_rig();
  rig.T_right_left.R.row(0) *= -1.0;  // a mirror
  expect_bad_text("camchain.yaml", test::kalibr_yaml(rig), {"no rotation"});
  rig = test::make_rig();
  rig.K_right(0, 0) = 0.0;
  expect_bad_text("stereo.yml", test::opencv_yaml(rig, false), {"singular", "(K2)"});
  rig = test::make_rig();
  rig.D_left[0] = 1e9;
  expect_bad_text("stereo.yml", test::opencv_yaml(rig, false), {"distortion coefficient is absurd"});
  rig = test::make_rig();
  rig.T_right_left.t = {-0.01, 0.3, 0.0};
  expect_bad_text("camchain.yaml", test::kalibr_yaml(rig), {"not side by side"});
  rig = test::make_rig();
  rig.P1(0, 0) = 0.0;
  expect_bad_text("stereo.yml", test::opencv_yaml(rig, true), {"projection is singular"});
  rig = test::make_rig();
  rig.width = 0;
  expect_bad_text("camchain.yaml", test::kalibr_yaml(rig), {"image size is absurd"});
}

TEST(bad_calibration, whose_rectification_does_not_fit_its_rig) {
  test::Rig rig = test::make_rig();
  rig.P2(0, 3) *= 1.2;
  expect_bad_text("stereo.yml", test::opencv_yaml(rig, true), {"does not fit rotation and baseline"});
  rig = test::make_rig();
  rig.R1 = so3_exp({0.0, 0.1, 0.0}) * rig.R1;
  expect_bad_text("calib_cam_to_cam.txt", test::kitti_raw_txt(rig), {"does not fit rotation and baseline"});
}

TEST(bad_calibration, with_values_that_are_no_numbers) {
  const test::Rig rig = test::make_rig();
  for (const char* junk : {"nan", "inf", "-inf", "abc", "1e999", "0x10", "1.5.2", "--3"}) {
    const std::string quoted = fmt::format("'{}'", junk);
    expect_bad_text("calib.txt", replace(test::kitti_calibration(), "31.5", junk), {quoted, "calib.txt:1"}, 64, 48);
    expect_bad_text("calib_cam_to_cam.txt", replace(test::kitti_raw_txt(rig), "458.654", junk), {quoted, ":4"});
    expect_bad_text("camchain.yaml", replace(test::kalibr_yaml(rig), "458.654", junk), {quoted, ":6 (intrinsics)"});
    expect_bad_text("stereo.yml", replace(test::opencv_yaml(rig, true), "458.654", junk), {quoted, "(K1)"});
    expect_bad_text("camera.txt", fmt::format("Pinhole {} 300 320 240 0\n640 480\ncrop\n640 480\n0.12\n", junk),
                    {quoted, "camera.txt:1"});
    expect_bad_text("camera.txt", fmt::format("Pinhole 300 300 320 240 0\n640 480\ncrop\n640 480\n{}\n", junk),
                    {quoted, "camera.txt:5"});
  }
  expect_bad_text("camchain.yaml", replace(test::kalibr_yaml(rig), "458.654", ".nan"), {"'.nan'"});
}

TEST(bad_calibration, with_rows_or_numbers_missing) {
  const test::Rig rig = test::make_rig();
  expect_bad_text("calib.txt", "P0: 100 0 31.5 0 0 100\nP1: 100 0 31.5 -50 0 100 23.5 0 0 0 1 0\n",
                  {"P0 has 6 numbers instead of 12", ":1"});
  expect_bad_text("camera.txt", "Pinhole 300 300 320 240 0\n640 480\ncrop\n", {"ends after 3 of 5 lines"});
  expect_bad_text("camera.txt", "Pinhole 300 300 320\n640 480\ncrop\n640 480\n0.12\n", {"3 numbers instead of 4"});
  expect_bad_text("camera.txt", "Pinhole 300 300 320 240 0\n640\ncrop\n640 480\n0.12\n", {"image size", ":2"});
  expect_bad_text("camera.txt", "Pinhole 300 300 320 240 0\n640 480\nzoom\n640 480\n0.12\n", {"mode", ":3"});
  expect_bad_text("camera.txt", "FOV 300 300 320 240 0.9\n640 480\ncrop\n640 480\n0.12\n", {"camera model"});
  expect_bad_text("camera.txt", "300 300 320 240 0.9\n640 480\ncrop\n640 480\n0.12\n", {"FOV"});
  expect_bad_text("camchain.yaml", replace(test::kalibr_yaml(rig), "radtan", "fov"), {"fov", "not known"});
  expect_bad_text("stereo.yml", replace(test::opencv_yaml(rig, true), "rows: 3", "rows: 4"),
                  {"9 numbers instead of 12"});
  expect_bad_text("camchain.yaml", replace(test::kalibr_yaml(rig), "1.0]", "2.0]"), {"last row"});
  expect_bad_text("calib.txt", "P0: 100 7 31.5 0 0 100 23.5 0 0 0 1 0\nP1: 100 0 31.5 -50 0 100 23.5 0 0 0 1 0\n",
                  {"rectified camera", "P0"});
}

// Wherever a file is cut, the result is an error or (past the last needed number) still a checked calibration.
TEST(bad_calibration, cut_at_any_byte_never_gives_an_unchecked_one) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const std::vector<std::pair<std::string, std::string>> files{
      {"calib.txt", test::kitti_calibration(300, 320, 320)},
      {"calib_cam_to_cam.txt", test::kitti_raw_txt(rig)},
      {"camchain.yaml", test::kalibr_yaml(rig)},
      {"stereo.yml", test::opencv_yaml(rig, true)},
      {"camera.txt", "Pinhole 300 300 320 240 0\n640 480\ncrop\n640 480\n0.12\n"},
  };
  for (const auto& [name, text] : files) {
    int errors = 0;
    for (std::size_t length = 0; length < text.size(); length += 7) {
      const auto c = read_calibration(write_file(dir + "/" + name, text.substr(0, length)), 640, 480);
      if (c.ok()) {
        EXPECT_GT(c->left.fx_px, 0.0);
        EXPECT_TRUE(c->T_right_left.is_finite());
        EXPECT_LT(c->T_right_left.t.x(), 0.0);
      } else {
        ++errors;
        test::expect_clear(c.error(), {name});
      }
    }
    EXPECT_GT(errors, static_cast<int>(text.size() / 7) / 2) << name;
  }
}

}  // namespace
}  // namespace cliquevo::drivers
