// SPDX-License-Identifier: BSD-3-Clause
// What a file leaves open or cannot be is said in one line that says what to do.
#include <fmt/format.h>

#include "drivers/calibration_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::write_file;

std::string rig_yaml(const std::string& D, const std::string& T, double f = 400.0, const std::string& more = "") {
  return fmt::format(
      "%YAML:1.0\nK1: [{0}, 0, 320, 0, {0}, 240, 0, 0, 1]\nD1: [{1}]\nK2: [{0}, 0, 320, 0, {0}, 240, 0, 0, "
      "1]\nD2: [{1}]\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [{2}]\n{3}",
      f, D, T, more);
}

Result<StereoCalibration> read(const std::string& text, const CalibrationOptions& options = {}, int width = 640,
                               int height = 480) {
  return read_calibration(write_file(test::scratch_dir() + "/stereo.yml", text), width, height, options);
}

void expect_refused(const std::string& text, const std::vector<std::string>& fragments,
                    const CalibrationOptions& options = {}, int width = 640, int height = 480) {
  const auto c = read(text, options, width, height);
  ASSERT_FALSE(c.ok()) << text;
  test::expect_clear(c.error(), fragments);
}

CalibrationOptions unit(double metres) {
  CalibrationOptions out;
  out.baseline_unit_m = metres;
  return out;
}

TEST(question, baselines_that_no_vehicle_carries) {
  const std::string D = "-0.3, 0.1, 0, 0, 0";
  expect_refused(rig_yaml(D, "-4.412, 0, 0"), {"4.412 m", "0.1103 m if in squares of 25 mm", "--baseline-unit 0.025"});
  expect_refused(rig_yaml(D, "-6.3, 0, 0"), {"6.3 m", "0.0630 m if in centimetres", "--baseline-unit 0.01"});
  expect_refused(rig_yaml(D, "-120, 0, 0"), {"120 m", "0.1200 m if in millimetres", "--baseline-unit 0.001"});
  expect_refused(rig_yaml(D, "-0.0012, 0, 0"), {"0.0012 m", "0.1200 m if divided by 100"});
  const auto squares = read(rig_yaml(D, "-4.412, 0, 0"), unit(0.025));
  ASSERT_TRUE(squares.ok()) << squares.error().line();
  EXPECT_NEAR(squares->T_right_left.t.norm(), 0.1103, 1e-9);
  const auto wide = read(rig_yaml(D, "-4.412, 0, 0"), unit(1.0));
  ASSERT_TRUE(wide.ok()) << wide.error().line();
  EXPECT_NEAR(wide->T_right_left.t.norm(), 4.412, 1e-9);
  // Thousandths cannot be anything else.
  const auto thousandths = read(rig_yaml(D, "-0.00012, 0, 0"));
  ASSERT_TRUE(thousandths.ok()) << thousandths.error().line();
  EXPECT_NEAR(thousandths->T_right_left.t.norm(), 0.12, 1e-9);
  ASSERT_EQ(thousandths->notes.size(), 1U);
  EXPECT_NE(thousandths->notes[0].find("0.12 m"), std::string::npos) << thousandths->notes[0];
  for (const char* usual : {"-0.02, 0, 0", "-0.063, 0, 0", "-0.54, 0, 0", "-0.9, 0, 0"}) {
    const auto c = read(rig_yaml(D, usual));
    ASSERT_TRUE(c.ok()) << c.error().line();
    EXPECT_TRUE(c->notes.empty());
  }
}

TEST(question, a_baseline_of_a_metre_and_more_is_taken_and_its_unit_told) {
  const std::string rig = rig_yaml("-0.3, 0.1, 0, 0, 0", "-1.2, 0, 0");
  const auto c = read(rig);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_NEAR(c->T_right_left.t.norm(), 1.2, 1e-9);
  ASSERT_EQ(c->notes.size(), 1U);
  EXPECT_NE(c->notes[0].find("1.2 m"), std::string::npos) << c->notes[0];
  EXPECT_NE(c->notes[0].find("--baseline-unit 0.025"), std::string::npos) << c->notes[0];
  // Not where the unit is known: by the user, a name, the format.
  EXPECT_TRUE(read(rig, unit(1.0))->notes.empty());
  std::string named = rig;
  named.replace(named.find("\nT:"), 3, "\nT_m:");
  const auto metres = read(named);
  ASSERT_TRUE(metres.ok()) << metres.error().line();
  EXPECT_TRUE(metres->notes.empty());
  const auto bf = read("Camera.fx: 400\nCamera.fy: 400\nCamera.cx: 320\nCamera.cy: 240\nCamera.bf: 480\n");
  ASSERT_TRUE(bf.ok()) << bf.error().line();
  EXPECT_TRUE(bf->notes.empty());
}

TEST(question, four_terms_that_two_lenses_fit) {
  const std::string T = "-0.1, 0, 0";
  // Wide, and next to nothing: a fisheye's k1 to k4, or a pinhole without distortion.
  const std::string open = rig_yaml("0.0035, 0.0007, -0.002, 0.0002", T, 190.0);
  expect_refused(open, {"unnamed lens", "--lens plumb_bob", "--lens equidistant"});
  for (const auto& [lens, model] :
       {std::pair{"plumb_bob", Distortion::plumb_bob}, {"equidistant", Distortion::equidistant}}) {
    CalibrationOptions options;
    options.lens = lens;
    const auto c = read(open, options);
    ASSERT_TRUE(c.ok()) << c.error().line();
    EXPECT_EQ(c->left.distortion, model);
  }
  const auto fisheye = read(rig_yaml("-0.003, 0.054, -0.0516, 0.0107", T, 282.0));
  ASSERT_TRUE(fisheye.ok()) << fisheye.error().line();
  EXPECT_EQ(fisheye->left.distortion, Distortion::equidistant);
  EXPECT_EQ(fisheye->notes.size(), 1U);
  const auto plain = read(rig_yaml("-0.28, 0.07, 0.0002, -0.0003", T));
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain->left.distortion, Distortion::plumb_bob);
  EXPECT_TRUE(plain->notes.empty());
  const auto named = read(rig_yaml("0.0035, 0.0007, -0.002, 0.0002", T, 190.0, "camera_model: fisheye\n"));
  ASSERT_TRUE(named.ok()) << named.error().line();
  EXPECT_EQ(named->left.distortion, Distortion::equidistant);
}

TEST(question, another_resolution_is_scaled_or_refused) {
  const std::string text = rig_yaml("-0.3, 0.1, 0, 0, 0", "-0.1, 0, 0", 400.0, "image_size: [640, 480]\n");
  for (const auto& [width, height, by] : {std::tuple{320, 240, 0.5}, {1280, 960, 2.0}, {480, 360, 0.75}}) {
    const auto c = read(text, {}, width, height);
    ASSERT_TRUE(c.ok()) << c.error().line();
    EXPECT_DOUBLE_EQ(c->left.fx_px, 400.0 * by);
    EXPECT_DOUBLE_EQ(c->left.cx_px, 320.5 * by - 0.5);
    EXPECT_EQ(c->left.width, width);
    ASSERT_EQ(c->notes.size(), 1U);
    EXPECT_NE(c->notes[0].find("scaled"), std::string::npos);
  }
  expect_refused(text, {"another image size", "640x480", "640x400"}, {}, 640, 400);
  expect_refused(text, {"another image size"}, {}, 636, 477);
  // Without a size in the file the principal point decides.
  const std::string unsized = rig_yaml("-0.3, 0.1, 0, 0, 0", "-0.1, 0, 0");
  const auto half = read(unsized, {}, 320, 240);
  ASSERT_TRUE(half.ok()) << half.error().line();
  EXPECT_DOUBLE_EQ(half->left.fx_px, 200.0);
  EXPECT_EQ(half->notes.size(), 1U);
  EXPECT_TRUE(read(unsized, {}, 600, 450)->notes.empty());
  expect_refused(unsized, {"another image size"}, {}, 470, 350);
}

TEST(question, numbers_that_no_camera_has) {
  const std::string T = "-0.1, 0, 0";
  for (const char* D : {"1000, 0, 0, 0", "0, 1e3, 0, 0", "-500, 0, 0, 0"}) {
    expect_refused(rig_yaml(D, T, 400.0, "distortion_model: equidistant\n"), {"distortion", "absurd"});
  }
  expect_refused(rig_yaml("-0.3, 0.1, 3.0, 0, 0", T), {"distortion", "absurd"});
  expect_refused(rig_yaml("-5, 0, 0, 0, 0", T), {"distortion", "absurd"});
  for (const char* t : {"-1e300, 0, 0", "-1e155, 1e155, 0", "0, 1e10, 0"}) {
    expect_refused(rig_yaml("-0.3, 0.1, 0, 0, 0", t), {"absurd", "(T)"});
  }
  const std::string kitti = "P0: 400 0 320 0 0 400 240 0 0 0 1 0\nP1: 400 0 320 -1e300 0 400 240 0 0 0 1 0\n";
  const auto c = read_calibration(write_file(test::scratch_dir() + "/calib.txt", kitti), 640, 480);
  ASSERT_FALSE(c.ok());
  test::expect_clear(c.error(), {"absurd", "calib.txt:2"});
}

TEST(question, rectified_images_take_the_rectified_pair_of_the_file) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  CalibrationOptions rectified;
  rectified.rectified = true;
  const auto c = read_calibration(write_file(dir + "/stereo.yml", test::opencv_yaml(rig, true)), 640, 480, rectified);
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_TRUE(c->rectified);
  EXPECT_NEAR(c->prescribed->model.fx_px, rig.P1(0, 0), 1e-9);
  EXPECT_NEAR(c->prescribed->model.baseline_m, rig.T_right_left.t.norm(), 1e-9);
  const auto none =
      read_calibration(write_file(dir + "/stereo.yml", test::opencv_yaml(rig, false)), 640, 480, rectified);
  ASSERT_FALSE(none.ok());
  test::expect_clear(none.error(), {"does not describe the rectified cameras", "P1 and P2"});
}

TEST(question, an_unknown_format_gets_what_was_looked_for_and_found) {
  expect_refused("%YAML:1.0\nsome_thing: 3\nother: [1, 2]\n",
                 {"no known format", "found: some_thing, other", "Kalibr", "OpenCV", "K1, D1", "DepthAI"});
  const auto text = read_calibration(write_file(test::scratch_dir() + "/notes.txt", "shopping list\n"), 0, 0);
  ASSERT_FALSE(text.ok());
  test::expect_clear(text.error(), {"no known format", "'shopping list'", "DSO"});
}

TEST(question, hostile_syntax_is_one_line) {
  std::string bomb = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (char c = 'b'; c < 'k'; ++c) {
    const auto before = static_cast<char>(c - 1);
    bomb += fmt::format("{0}: &{0} [*{1}, *{1}, *{1}, *{1}, *{1}, *{1}, *{1}, *{1}, *{1}, *{1}]\n", c, before);
  }
  expect_refused(bomb, {"too deep or too large"});
  std::string deep = "<?xml version=\"1.0\"?>\n";
  for (int i = 0; i < 10000; ++i) deep += "<a>";
  expect_refused(deep, {"XML"});
  for (const char* xml : {"<opencv_storage>", "<", "<a", "<a></b>", "<a><b>1</a>", "<?xml", "<!-- ", "<a>\n</a"}) {
    expect_refused(xml, {"stereo.yml"});
  }
}

}  // namespace
}  // namespace cliquevo::drivers
