// SPDX-License-Identifier: BSD-3-Clause
// Names of lens models in all formats, and whether a lens can be.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/text_file.h"
#include "stereo/camera_projection.h"

namespace cliquevo::drivers {

namespace {

constexpr char kRemedy[] =
    "use plumb_bob (radtan), rational_polynomial, thin_prism, equidistant (kb4), omni, eucm, ds or none";

struct Name {
  const char* name;  // without blanks, '_', '-' and "pinhole" in front
  Distortion model;
};
constexpr std::array<Name, 41> kNames{{{"none", Distortion::none},
                                       {"ideal", Distortion::none},
                                       {"undistorted", Distortion::none},
                                       {"rectified", Distortion::none},
                                       {"plumbbob", Distortion::plumb_bob},
                                       {"radtan", Distortion::plumb_bob},
                                       {"radtan4", Distortion::plumb_bob},
                                       {"radtan5", Distortion::plumb_bob},
                                       {"radialtangential", Distortion::plumb_bob},
                                       {"brown", Distortion::plumb_bob},
                                       {"brownconrady", Distortion::plumb_bob},
                                       {"modifiedbrownconrady", Distortion::plumb_bob},
                                       {"rational", Distortion::rational},
                                       {"rationalpolynomial", Distortion::rational},
                                       {"radialtangential8", Distortion::rational},
                                       {"radtan8", Distortion::rational},
                                       {"thinprism", Distortion::thin_prism},
                                       {"thinprismrational", Distortion::thin_prism},
                                       {"equidistant", Distortion::equidistant},
                                       {"equidist", Distortion::equidistant},
                                       {"equi", Distortion::equidistant},
                                       {"fisheye", Distortion::equidistant},
                                       {"opencvfisheye", Distortion::equidistant},
                                       {"kannalabrandt", Distortion::equidistant},
                                       {"kannalabrandt4", Distortion::equidistant},
                                       {"kannalabrandt8", Distortion::equidistant},
                                       {"kb", Distortion::equidistant},
                                       {"kb4", Distortion::equidistant},
                                       {"kb8", Distortion::equidistant},
                                       {"omni", Distortion::unified},
                                       {"omniradtan", Distortion::unified},
                                       {"omninone", Distortion::unified},
                                       {"omnidirectional", Distortion::unified},
                                       {"mei", Distortion::unified},
                                       {"unified", Distortion::unified},
                                       {"eucm", Distortion::extended_unified},
                                       {"eucmnone", Distortion::extended_unified},
                                       {"extendedunified", Distortion::extended_unified},
                                       {"ds", Distortion::double_sphere},
                                       {"dsnone", Distortion::double_sphere},
                                       {"doublesphere", Distortion::double_sphere}}};
// Names that leave the model to the number of coefficients.
constexpr std::array<const char*, 5> kPlain{"", "pinhole", "perspective", "opencv", "standard"};

std::string key_of(const std::string& name) {
  std::string key;
  for (const char c : name) {
    if (c == '_' || c == '-' || c == ' ' || c == '"') continue;
    key += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  if (key.size() > 7 && key.compare(0, 7, "pinhole") == 0) key.erase(0, 7);
  return key;
}

Error wrong_count(std::size_t n, const char* instead, const std::string& where) {
  return {fmt::format("distortion has {} numbers instead of {}", n, instead), where, "copy the calibration again"};
}

Distortion by_number(std::size_t n) {
  if (n == 0) return Distortion::none;
  if (n <= 5) return Distortion::plumb_bob;
  return n <= 8 ? Distortion::rational : Distortion::thin_prism;
}

// More numbers than the model has, all of the rest 0, are as good as so many.
std::size_t filled(const std::vector<double>& v) {
  std::size_t n = v.size();
  while (n > 0 && v[n - 1] == 0.0) --n;
  return n;
}

Result<void> put(const std::vector<double>& v, const std::string& where, CameraCalibration& camera) {
  const std::size_t n = v.size();
  const std::size_t used = filled(v);
  const auto first = [&](std::size_t most) {
    std::copy_n(v.begin(), std::min({n, most, camera.coefficients.size()}), camera.coefficients.begin());
    return Result<void>{};
  };
  switch (camera.distortion) {
    case Distortion::none:
      return used == 0 ? Result<void>{} : Error{"distortion has terms but no model", where, kRemedy};
    case Distortion::plumb_bob:
      if (n != 0 && n != 4 && n != 5 && n != 8 && n != 12 && n != 14) return wrong_count(n, "4 or 5", where);
      if (used > 5) {  // called plumb_bob, and is more
        camera.distortion = used > 8 ? Distortion::thin_prism : Distortion::rational;
        return put(v, where, camera);
      }
      return first(5);
    case Distortion::rational:
    case Distortion::thin_prism:
      if (n != 4 && n != 5 && n != 8 && n != 12 && n != 14) return wrong_count(n, "8, 12 or 14", where);
      camera.distortion = used > 8 ? Distortion::thin_prism : Distortion::rational;
      for (std::size_t i = 8; i < n; ++i) camera.prism[i - 8] = v[i];
      return first(8);
    case Distortion::equidistant:
      if (n < 4 || used > 4) return wrong_count(n, "4", where);
      return first(4);
    case Distortion::unified:
      if (n < 1 || n > 5) return wrong_count(n, "xi and 4", where);
      return first(5);
    case Distortion::extended_unified:
    case Distortion::double_sphere:
      if (n != 2) return wrong_count(n, "2", where);
      return first(2);
  }
  return {};
}

// Terms of the sphere models are bounded by what they mean.
bool sphere_terms_can_be(const CameraCalibration& c) {
  const auto& k = c.coefficients;
  switch (c.distortion) {
    case Distortion::unified:
      return k[0] >= 0.0 && k[0] <= 50.0;
    case Distortion::extended_unified:
      return k[0] >= 0.0 && k[0] <= 1.0 && k[1] > 0.0 && k[1] <= 50.0;
    case Distortion::double_sphere:
      return k[0] > -1.0 && k[0] <= 1.0 && k[1] >= 0.0 && k[1] <= 1.0;
    default:
      return true;
  }
}

}  // namespace

Result<void> set_distortion(const std::string& name, const std::vector<double>& coefficients, const std::string& where,
                            CameraCalibration& camera) {
  const std::string key = key_of(name);
  const std::size_t n = coefficients.size();
  camera.coefficients.fill(0.0);
  camera.prism.fill(0.0);
  const auto* known = std::find_if(kNames.begin(), kNames.end(), [&](const Name& entry) { return key == entry.name; });
  if (known != kNames.end()) {
    camera.distortion = known->model;
  } else if (std::find(kPlain.begin(), kPlain.end(), key) != kPlain.end()) {
    camera.distortion = by_number(n);
  } else if (filled(coefficients) == 0) {
    camera.distortion = Distortion::none;  // whatever its name, it bends nothing
    if (key.find("fish") != std::string::npos || key.find("theta") != std::string::npos) {
      return Error{"distortion model " + printable(key.substr(0, 32)) + " is not known", where, kRemedy};
    }
    return {};
  } else {
    return Error{"distortion model " + printable(key.substr(0, 32)) + " is not known", where, kRemedy};
  }
  return put(coefficients, where, camera);
}

bool is_lens_name(const std::string& name) {
  const std::string key = key_of(name);
  const bool plain = std::any_of(kPlain.begin(), kPlain.end(), [&](const char* known) { return key == known; });
  return plain || std::any_of(kNames.begin(), kNames.end(), [&](const Name& entry) { return key == entry.name; });
}

Result<void> check_lens(const CameraCalibration& c, const std::string& where) {
  if (!sphere_terms_can_be(c)) return calibration_error("distortion of the lens is absurd", where);
  for (const double term : c.prism) {
    if (!std::isfinite(term) || std::abs(term) > 10.0) {
      return calibration_error("distortion coefficient is absurd", where);
    }
  }
  if (c.width <= 0) return {};
  const stereo::CameraProjection projection(c);
  if (!projection.is_plausible()) {
    return Error{"distortion of the lens is absurd", where,
                 fmt::format("with these terms it does not project onto an image of {}x{}: calibrate the cameras "
                             "again or name the right model and file",
                             c.width, c.height)};
  }
  return {};
}

}  // namespace cliquevo::drivers
