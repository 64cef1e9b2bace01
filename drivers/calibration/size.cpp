// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/size.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"

namespace cliquevo::drivers {

namespace {

constexpr double kMostScale = 8.0;
constexpr double kSameAspect = 0.01;      // sizes are whole pixels
constexpr double kLeastChange = 0.02;     // less is a crop or a mix-up, no change of resolution
constexpr double kOffCentre = 0.2;        // share of the side that a principal point of a whole image stays within
constexpr double kAgreeingScales = 0.08;  // scales by both coordinates of principal points
constexpr double kUnscaled = 0.16;        // deviations of principal points that need no explanation
// By which cameras' and users' resolutions differ.
constexpr std::array<double, 9> kUsualScales{0.125, 0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 1.5, 2.0, 3.0, 4.0};

void scale(CameraCalibration& c, double by, int width, int height) {
  c.fx_px *= by;
  c.fy_px *= by;
  c.cx_px = (c.cx_px + 0.5) * by - 0.5;  // pixel centres are whole numbers
  c.cy_px = (c.cy_px + 0.5) * by - 0.5;
  c.width = width;
  c.height = height;
}

void scale(StereoCalibration& c, double by, int width, int height) {
  if (c.prescribed) {
    StereoModel& m = c.prescribed->model;
    m.fx_px *= by;
    m.fy_px *= by;
    m.cx_px = (m.cx_px + 0.5) * by - 0.5;
    m.cy_px = (m.cy_px + 0.5) * by - 0.5;
    m.doffs_px *= by;
    const bool of_the_images = m.width == 0 || (m.width == c.left.width && m.height == c.left.height);
    m.width = of_the_images ? width : static_cast<int>(std::lround(m.width * by));
    m.height = of_the_images ? height : static_cast<int>(std::lround(m.height * by));
  }
  scale(c.left, by, width, height);
  scale(c.right, by, width, height);
}

bool is_centred(const CameraCalibration& c) {
  return std::abs(c.cx_px / c.width - 0.5) < kOffCentre && std::abs(c.cy_px / c.height - 0.5) < kOffCentre;
}

// Both principal points off the middle the same way, in both coordinates: the size is not that of the numbers.
bool is_of_another_size(const CameraCalibration& l, const CameraCalibration& r) {
  constexpr double kFarOff = 0.2;
  constexpr double kOff = 0.1;
  const auto together = [](double a, double b, double least) {
    return std::min(a, b) > least || std::max(a, b) < -least;
  };
  const double lx = l.cx_px / l.width - 0.5;
  const double rx = r.cx_px / r.width - 0.5;
  const double ly = l.cy_px / l.height - 0.5;
  const double ry = r.cy_px / r.height - 0.5;
  const bool same_way = (lx > 0.0) == (ly > 0.0);
  return same_way && together(lx, rx, kFarOff) && together(ly, ry, kOff);
}

// Calibrators of cameras that deliver both images side by side keep the size of what they grabbed.
void halve_width(StereoCalibration& c, const CalibrationRequest& request) {
  constexpr double kMiddle = 0.2;
  for (const CameraCalibration* camera : {&c.left, &c.right}) {
    if (camera->width != 2 * request.width || camera->height != request.height || c.prescribed ||
        std::abs(camera->cx_px / request.width - 0.5) > kMiddle) {
      return;
    }
  }
  c.notes.push_back(fmt::format("calibration is for {}x{}, both images side by side: taken for {}x{} each",
                                c.left.width, c.left.height, request.width, request.height));
  c.left.width = c.right.width = request.width;
}

Error other_size(const CameraCalibration& c, const std::string& where) {
  return {"calibration is of another image size", where,
          fmt::format("its principal point {:.1f}, {:.1f} px suits about {:.0f}x{:.0f}, the images are {}x{}: name "
                      "the calibration of these images",
                      c.cx_px, c.cy_px, 2.0 * c.cx_px, 2.0 * c.cy_px, c.width, c.height)};
}

// Files without a size (KITTI odometry, some of OpenCV's) betray another one by principal points far from the middle.
// The scale that explains them; 1 = none needed, nothing = another image altogether.
std::optional<double> scale_by_centres(const CameraCalibration& l, const CameraCalibration& r) {
  const double off_x = std::abs(l.cx_px / l.width - 0.5);
  const double off_y = std::abs(l.cy_px / l.height - 0.5);
  const double x = 0.5 * (l.cx_px + r.cx_px + 1.0) * 2.0 / l.width;
  const double y = 0.5 * (l.cy_px + r.cy_px + 1.0) * 2.0 / l.height;
  const bool together = x > 0.0 && y > 0.0 && std::abs(x / y - 1.0) < kAgreeingScales;
  if (together && std::abs(x - 1.0) > kUnscaled && std::abs(y - 1.0) > kUnscaled) {
    const double by = 2.0 / (x + y);
    for (const double usual : kUsualScales) {
      if (std::abs(by / usual - 1.0) < kAgreeingScales) return usual;
    }
    return std::nullopt;
  }
  // Cropped in height, as recordings of roads are: not another size.
  if ((off_x < 0.25 || off_y < 0.25) && off_x < 0.4) return 1.0;
  return std::nullopt;
}

Result<void> settle_unsized(StereoCalibration& c, const CalibrationRequest& request) {
  for (CameraCalibration* camera : {&c.left, &c.right}) {
    camera->width = request.width;
    camera->height = request.height;
  }
  if (request.width <= 0) return {};
  if (!std::isfinite(c.left.cx_px) || !std::isfinite(c.left.cy_px)) return {};
  for (const CameraCalibration* camera : {&c.left, &c.right}) {  // absurd ones are reported as such
    if (std::abs(camera->cx_px) > 16384.0 || std::abs(camera->cy_px) > 16384.0) return {};
  }
  const std::optional<double> by = scale_by_centres(c.left, c.right);
  if (!by) return other_size(c.left, request.path);
  if (*by == 1.0) return {};
  c.notes.push_back(fmt::format(
      "the principal point {:.1f}, {:.1f} px of the calibration is that of an image {:.4g} times as large as {}x{}: "
      "scaled by {:.4g}",
      c.left.cx_px, c.left.cy_px, 1.0 / *by, request.width, request.height, *by));
  scale(c, *by, request.width, request.height);
  return {};
}

}  // namespace

Result<void> settle_size(StereoCalibration& c, const CalibrationRequest& request) {
  const bool unsized = c.left.width == 0 && c.left.height == 0 && c.right.width == 0 && c.right.height == 0;
  if (unsized) return settle_unsized(c, request);
  for (const CameraCalibration* camera : {&c.left, &c.right}) {
    if (camera->width < 16 || camera->height < 16 || camera->width > 16384 || camera->height > 16384) {
      return calibration_error(fmt::format("image size {}x{} is absurd", camera->width, camera->height), request.path);
    }
  }
  const CameraCalibration& l = c.left;
  if (l.width != c.right.width || l.height != c.right.height) {
    return calibration_error(
        fmt::format("cameras have unequal sizes ({}x{} and {}x{})", l.width, l.height, c.right.width, c.right.height),
        request.path);
  }
  halve_width(c, request);
  if (is_of_another_size(c.left, c.right)) {
    return Error{"calibration is of another image size than it says", request.path,
                 fmt::format("it says {}x{}, but its principal point {:.1f}, {:.1f} px suits about {:.0f}x{:.0f}: "
                             "correct the size in the file, or name the calibration of these images",
                             l.width, l.height, l.cx_px, l.cy_px, 2.0 * l.cx_px, 2.0 * l.cy_px)};
  }
  if (request.width <= 0 || (l.width == request.width && l.height == request.height)) return {};
  const double by = static_cast<double>(request.width) / l.width;
  const double by_height = static_cast<double>(request.height) / l.height;
  const bool whole = std::abs(by_height / by - 1.0) < kSameAspect && std::abs(by - 1.0) > kLeastChange &&
                     by < kMostScale && by > 1.0 / kMostScale && is_centred(c.left) && is_centred(c.right);
  if (!whole) return size_error(request.path, l.width, l.height, request.width, request.height);
  c.notes.push_back(fmt::format("calibration is for {}x{}, the images are {}x{}: scaled by {:.4g}", l.width, l.height,
                                request.width, request.height, by));
  scale(c, by, request.width, request.height);
  return {};
}

}  // namespace cliquevo::drivers
