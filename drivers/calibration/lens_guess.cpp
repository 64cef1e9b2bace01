// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/lens_guess.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration/checks.h"

namespace cliquevo::drivers {

namespace {

constexpr char kQuestion[] = "distortion has four terms of an unnamed lens";

// Decentring of real lenses stays below some thousandths; a fisheye's k3 and k4 are as large as its k2.
constexpr double kMostDecentring = 0.015;
// tan of half the field of view by the focal length alone, beyond which a lens without barrel distortion is unusual:
// 45 degrees.
constexpr double kWide = 1.0;
constexpr double kBarrel = -0.1;
constexpr double kMostTerm = 2.0;  // of any fisheye that is worth a guess

bool can_be(const char* lens, CameraCalibration camera, const std::vector<double>& D) {
  return set_distortion(lens, D, "", camera).ok() && check_lens(camera, "").ok();
}

double decentring(const std::vector<double>& D) { return std::max(std::abs(D[2]), std::abs(D[3])); }

// By the principal point where the file has no size.
double half_field(const CameraCalibration& c) { return (c.width > 0 ? 0.5 * c.width : c.cx_px) / c.fx_px; }

}  // namespace

LensGuess guess_lens(const CameraCalibration& left, const std::vector<double>& D_left, const CameraCalibration& right,
                     const std::vector<double>& D_right) {
  const auto zero = [](const std::vector<double>& D) {
    return std::all_of(D.begin(), D.end(), [](double k) { return k == 0.0; });
  };
  if (left.fx_px <= 0.0 || right.fx_px <= 0.0 || (zero(D_left) && zero(D_right))) return {"plumb_bob", ""};
  const double p = std::max(decentring(D_left), decentring(D_right));
  const bool plumb_bob =
      p < kMostDecentring && can_be("plumb_bob", left, D_left) && can_be("plumb_bob", right, D_right);
  const bool fisheye = can_be("equidistant", left, D_left) && can_be("equidistant", right, D_right);
  const auto usual = [](const std::vector<double>& D) {
    return std::all_of(D.begin(), D.end(), [](double k) { return std::abs(k) < kMostTerm; });
  };
  if (!plumb_bob && !(usual(D_left) && usual(D_right))) return {"plumb_bob", ""};  // which is refused then
  const bool wide = std::min(half_field(left), half_field(right)) > kWide;
  if (!plumb_bob && fisheye && (wide || p > 3.0 * kMostDecentring)) {
    return {"equidistant", fmt::format("four distortion terms without a model's name taken for a fisheye's "
                                       "(equidistant), as p1, p2 of {:.2g} fit no plumb bob lens; --lens plumb_bob if "
                                       "it is one",
                                       p)};
  }
  if (plumb_bob && fisheye && wide && D_left[0] > kBarrel && D_right[0] > kBarrel) return {};
  if (!plumb_bob && fisheye) return {};
  return {"plumb_bob", ""};
}

Error lens_question(const std::string& where) {
  return {kQuestion, where,
          "say which: --lens plumb_bob (k1 k2 p1 p2) or --lens equidistant (k1 k2 k3 k4 of a fisheye); in a "
          "configuration: lens"};
}

bool asks_for_lens(const Error& error) { return error.what == kQuestion; }

}  // namespace cliquevo::drivers
