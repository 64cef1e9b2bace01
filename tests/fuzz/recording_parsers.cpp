// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fuzz/recording_parsers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/calibration/calibration.h"
#include "drivers/recording/stamps.h"
#include "drivers/recording/times_file.h"
#include "drivers/text_file.h"

namespace cliquevo::fuzz {

namespace {

constexpr std::array<const char*, 8> kNames{"calib.txt",     "calib_cam_to_cam.txt", "camera.txt", "left.yaml",
                                            "camchain.yaml", "cam0/sensor.yaml",     "stereo.yml", "times.txt"};

std::string judge(const Error& error) {
  if (error.what.empty() || error.where.empty() || error.remedy.empty()) return "error lacks a part: " + error.line();
  for (const char c : error.line()) {
    if (c == '\n' || c == '\r' || c == '\0') return "error is not one line: " + error.line();
  }
  return {};
}

std::string judge(const CameraCalibration& c) {
  if (!(c.fx_px > 0.0) || !(c.fy_px > 0.0) || !std::isfinite(c.fx_px) || !std::isfinite(c.fy_px)) return "focal length";
  if (!std::isfinite(c.cx_px) || !std::isfinite(c.cy_px)) return "principal point";
  if (c.width != 640 || c.height != 480) return "size";
  for (const double k : c.coefficients) {
    if (!std::isfinite(k)) return "distortion";
  }
  return {};
}

std::string judge(const StereoCalibration& c) {
  for (const CameraCalibration* camera : {&c.left, &c.right}) {
    if (std::string bad = judge(*camera); !bad.empty()) return bad;
  }
  if (!c.T_right_left.is_finite() || !(c.T_right_left.t.x() < 0.0)) return "pose of the cameras";
  const Eigen::Matrix3d& R = c.T_right_left.R;
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-9) return "rotation of the cameras";
  if (c.rectified && !c.prescribed) return "rectified without a model";
  if (c.prescribed) {
    if (!c.prescribed->R_left.allFinite() || !c.prescribed->R_right.allFinite()) return "rectifying rotations";
    if (!c.prescribed->model.check().ok()) return "rectified model";
  }
  return {};
}

std::string parse_calibration_text(const std::string& name, const std::string& text) {
  drivers::CalibrationRequest request;
  request.path = "/made/up/" + name;
  request.width = 640;
  request.height = 480;
  const auto c =
      drivers::parse_calibration(text, request, [&](const std::vector<std::string>&) -> Result<drivers::NamedText> {
        return drivers::NamedText{request.path + ".other", text};
      });
  return c.ok() ? judge(*c) : judge(c.error());
}

std::string parse_times_text(const std::string& text) {
  const auto table = drivers::parse_times(drivers::utf8_of(text), "/made/up/times.txt");
  if (!table.ok()) return judge(table.error());
  std::vector<TimestampNs> stamps;
  for (const drivers::StampRow& row : table->rows) {
    if (std::abs(row.stamp_ns) > drivers::kMostStampNs) return "stamp out of bounds";
    stamps.push_back(row.stamp_ns);
  }
  if (stamps.empty()) return "no rows and no error";
  const auto rising = drivers::make_rising(stamps, "/made/up/times.txt");
  if (!rising.ok()) return judge(rising.error());
  std::optional<TimestampNs> last;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (rising->skipped[i]) continue;
    if (last && rising->stamps_ns[i] <= *last) return "stamps do not rise";
    last = rising->stamps_ns[i];
  }
  return {};
}

std::uint64_t next(std::uint64_t& state) {  // splitmix64
  std::uint64_t z = (state += 0x9E3779B97F4A7C15U);
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

}  // namespace

int parser_count() { return static_cast<int>(kNames.size()); }

std::string parse_anything(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return {};
  const std::string name = kNames[data[0] % kNames.size()];
  const std::string text(data + 1, data + size);
  std::string bad = name == "times.txt" ? parse_times_text(text) : parse_calibration_text(name, text);
  return bad.empty() ? bad : name + ": " + bad;
}

std::string mutated(std::string text, std::uint64_t& state) {
  static constexpr std::array<const char*, 30> kWords{"nan",     "inf",
                                                      "-1",      "0",
                                                      "1e308",   "-1e-308",
                                                      "1e99999", "[",
                                                      "]",       "{",
                                                      "}",       ":",
                                                      "\n",      "- ",
                                                      "&a ",     "*a",
                                                      "!!",      "%YAML",
                                                      "---\n",   "#",
                                                      "'",       "\"",
                                                      ",",       "data",
                                                      "rows: 3", "99999999999999999999",
                                                      "\t",      "P1: ",
                                                      "K_00: ",  "cam1:\n"};
  const int changes = 1 + static_cast<int>(next(state) % 4);
  for (int i = 0; i < changes; ++i) {
    const std::size_t at = text.empty() ? 0 : next(state) % text.size();
    const std::size_t length = std::min<std::size_t>(text.size() - at, 1 + next(state) % 40);
    switch (next(state) % 7) {
      case 0:
        text.resize(at);
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(next(state) % (text.size() + 1), length));
        break;
      case 3:
        text.insert(at, kWords[next(state) % kWords.size()]);
        break;
      case 4:
        text.replace(at, length, kWords[next(state) % kWords.size()]);
        break;
      case 5:
        if (!text.empty()) text[at] = static_cast<char>(next(state) & 255U);
        break;
      default:
        if (!text.empty() && text[at] >= '0' && text[at] <= '9') text[at] = static_cast<char>('0' + next(state) % 10);
    }
  }
  return text;
}

}  // namespace cliquevo::fuzz
