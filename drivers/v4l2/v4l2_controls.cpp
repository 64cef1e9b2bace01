// SPDX-License-Identifier: BSD-3-Clause
// Exposure, gain and the other controls of a camera.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <linux/videodev2.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/v4l2/v4l2_camera.h"

namespace cliquevo::drivers {

namespace {

constexpr double kUsPerStep = 100.0;  // of V4L2_CID_EXPOSURE_ABSOLUTE

std::string plain_name(const char* name) {
  std::string out;
  for (const char* c = name; *c != '\0'; ++c) {
    if (std::isalnum(static_cast<unsigned char>(*c)) != 0) {
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(*c)));
    } else if (!out.empty() && out.back() != '_') {
      out += '_';
    }
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out;
}

struct ControlRange {
  std::int32_t least = 0;
  std::int32_t most = 0;
};

std::optional<ControlRange> range_of(int descriptor, std::uint32_t id) {
  v4l2_queryctrl query = {};
  query.id = id;
  if (control_device(descriptor, VIDIOC_QUERYCTRL, &query) != 0) return std::nullopt;
  if ((query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) return std::nullopt;
  return ControlRange{query.minimum, query.maximum};
}

}  // namespace

std::optional<std::int32_t> V4l2Camera::control(std::uint32_t id) const {
  v4l2_control control = {id, 0};
  if (control_device(descriptor_, VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
  return control.value;
}

bool V4l2Camera::set_control(std::uint32_t id, std::int32_t value) const {
  v4l2_control control = {id, value};
  return control_device(descriptor_, VIDIOC_S_CTRL, &control) == 0;
}

std::vector<std::pair<std::string, std::uint32_t>> V4l2Camera::list_controls() const {
  std::vector<std::pair<std::string, std::uint32_t>> out;
  v4l2_queryctrl query = {};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (control_device(descriptor_, VIDIOC_QUERYCTRL, &query) == 0) {
    if ((query.flags & V4L2_CTRL_FLAG_DISABLED) == 0 && query.type != V4L2_CTRL_TYPE_CTRL_CLASS) {
      out.emplace_back(plain_name(reinterpret_cast<const char*>(query.name)), query.id);
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return out;
}

Result<void> V4l2Camera::set_controls(const CameraOptions& options, bool follows) {
  exposure_range_.reset();
  if (options.exposure_max_us > 0.0 && !options.exposure_us && !follows) {
    if (auto ok = limit_exposure(options); !ok) return ok;
  }
  const bool manual = options.exposure_us.has_value() || follows || exposure_range_;
  set_control(V4L2_CID_EXPOSURE_AUTO, manual ? V4L2_EXPOSURE_MANUAL : V4L2_EXPOSURE_APERTURE_PRIORITY);
  if (options.gain.has_value() || follows || exposure_range_) set_control(V4L2_CID_AUTOGAIN, 0);
  if (options.exposure_us) {
    const auto value = static_cast<std::int32_t>(std::lround(*options.exposure_us / 100.0));
    if (!set_control(V4L2_CID_EXPOSURE_ABSOLUTE, value)) return refused("the exposure time (set exposure_us to auto)");
    exposure_ns_ = static_cast<std::int64_t>(value) * 100'000;
  }
  if (options.gain && !set_control(V4L2_CID_GAIN, static_cast<std::int32_t>(std::lround(*options.gain)))) {
    return refused("the gain (set gain to auto)");
  }
  return set_named_controls(options.controls);
}

// "name=value,name=value".
Result<void> V4l2Camera::set_named_controls(const std::string& controls) const {
  const auto known = list_controls();
  for (std::size_t begin = 0; begin < controls.size();) {
    const std::size_t end = std::min(controls.find(',', begin), controls.size());
    const std::string item = controls.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t equals = item.find('=');
    const std::string name = item.substr(0, equals);
    const auto found = std::find_if(known.begin(), known.end(), [&](const auto& c) { return c.first == name; });
    if (found == known.end()) {
      std::vector<std::string> names;
      names.reserve(known.size());
      for (const auto& control : known) names.push_back(control.first);
      return Error{"no such control", fmt::format("{}: {}", path_, name),
                   fmt::format("it has {}", fmt::join(names, ", "))};
    }
    std::int32_t value = 0;
    const char* from = item.data() + std::min(equals, item.size() - 1) + 1;
    const auto [stop, failed] = std::from_chars(from, item.data() + item.size(), value);
    if (equals == std::string::npos || failed != std::errc{} || stop != item.data() + item.size()) {
      return Error{"wrong control", fmt::format("{}: {}", path_, item), "give name=number,name=number"};
    }
    if (!set_control(found->second, value)) return refused("the control " + item);
  }
  return {};
}

// The controls of Video4Linux know no limit of the exposure time: it is ours that acts (exposure_range_).
Result<void> V4l2Camera::limit_exposure(const CameraOptions& options) {
  const auto exposure = range_of(descriptor_, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!exposure || exposure->least * kUsPerStep > options.exposure_max_us) {
    return refused("so short a limit of its exposure time (set exposure_max_us to more, or to 0)");
  }
  const ControlRange gain = range_of(descriptor_, V4L2_CID_GAIN).value_or(ControlRange{});
  ExposureRange range{{std::max(1, exposure->least) * kUsPerStep, static_cast<double>(gain.least)},
                      {exposure->most * kUsPerStep, static_cast<double>(gain.most)}};
  range.most.exposure_us = std::min(range.most.exposure_us, options.exposure_max_us);
  if (options.gain) range.least.gain = range.most.gain = *options.gain;
  exposure_range_ = range;
  return {};
}

void V4l2Camera::control_exposure(ImageView<const std::uint8_t> image) {
  if (!exposure_range_) return;
  const auto exposure = control(V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!exposure) return;
  const auto gain = control(V4L2_CID_GAIN);
  const ExposureSetting next =
      next_exposure(image, {*exposure * kUsPerStep, static_cast<double>(gain.value_or(0))}, *exposure_range_);
  const auto steps = static_cast<std::int32_t>(next.exposure_us / kUsPerStep);  // never above the limit
  if (steps != *exposure && set_control(V4L2_CID_EXPOSURE_ABSOLUTE, steps)) {
    exposure_ns_ = static_cast<std::int64_t>(steps) * 100'000;
  }
  const auto next_gain = static_cast<std::int32_t>(std::lround(next.gain));
  if (gain && next_gain != *gain) set_control(V4L2_CID_GAIN, next_gain);
}

}  // namespace cliquevo::drivers
