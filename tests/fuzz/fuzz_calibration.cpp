// SPDX-License-Identifier: BSD-3-Clause
// Calibrations in all formats. The first byte chooses the file's name, the second the options; other files
// that the format needs have the same text.
#include <array>
#include <cmath>
#include <string>

#include "drivers/calibration/calibration.h"
#include "stereo/rectification.h"
#include "tests/fuzz/expect.h"

namespace {

using namespace cliquevo;  // NOLINT: a program of its own
using cliquevo::fuzz::expect;

constexpr std::array<const char*, 10> kNames{"calib.txt",  "calib_0.txt",     "rig.yaml", "rig.json",
                                             "stereo.xml", "SN0000.conf",     "ost.txt",  "left/left.yaml",
                                             "rig",        "calib_stereo.txt"};

void judge(const CameraCalibration& c) {
  expect(c.width == 640 && c.height == 480, "size");
  for (const double v : {c.fx_px, c.fy_px, c.cx_px, c.cy_px}) expect(std::isfinite(v), "camera matrix");
  expect(c.fx_px > 0.0 && c.fy_px > 0.0, "focal length");
  for (const double v : c.coefficients) expect(std::isfinite(v), "distortion");
  for (const double v : c.prism) expect(std::isfinite(v), "thin prism");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2 || size > 20000) return 0;
  drivers::CalibrationRequest request;
  request.path = std::string("/made/up/") + kNames[data[0] % kNames.size()];
  request.width = 640;
  request.height = 480;
  if ((data[1] & 1U) != 0) request.options.baseline_unit_m = 0.025;
  if ((data[1] & 2U) != 0) request.options.rectified = true;
  if ((data[1] & 4U) != 0) request.options.lens = "equidistant";
  const std::string text(reinterpret_cast<const char*>(data) + 2, size - 2);
  const auto c = drivers::parse_calibration(
      text, request, [&](const std::vector<std::string>& paths) -> Result<drivers::NamedText> {
        return drivers::NamedText{paths.empty() ? "/made/up/other" : paths.front(), text};
      });
  if (!c) {
    fuzz::expect_clear(c.error());
    return 0;
  }
  if (request.options.rectified && !c->rectified) expect(false, "rectified images have a rectified pair");
  judge(c->left);
  judge(c->right);
  expect(c->T_right_left.is_finite() && c->T_right_left.t.x() < 0.0, "the right camera lies on the right");
  const double baseline_m = c->T_right_left.t.norm();
  expect(baseline_m >= 1e-4 && baseline_m <= 50.0, "baseline");
  if (c->rectified) expect(c->prescribed.has_value(), "a rectified pair has its model");
  if (c->prescribed) expect(c->prescribed->model.check().ok(), "rectified model");
  if (size % 8 != 0) return 0;  // the rest is a search that takes as long as a hundred calibrations
  if (const auto chosen = stereo::choose_rectification(*c)) {
    expect(chosen->model.check().ok(), "model");
  } else {
    fuzz::expect_clear(chosen.error());
  }
  return 0;
}
