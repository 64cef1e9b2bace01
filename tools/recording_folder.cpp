// SPDX-License-Identifier: BSD-3-Clause
#include "tools/recording_folder.h"

#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/images/png_writer.h"
#include "tools/output_file.h"

namespace cliquevo::tools {

namespace fs = std::filesystem;

namespace {

Result<void> write_png(const std::string& path, const Result<std::vector<unsigned char>>& png) {
  if (!png) return Error{"cannot write image", path, png.error().remedy};
  auto file = OutputFile::open(path, "image");
  if (!file) return file.error();
  return file->write(*png);
}

std::string numbers(const double* first, int count) {
  return fmt::format("[{}]", fmt::join(first, first + count, ", "));
}

struct NamedDistortion {
  const char* euroc;
  const char* ros;
  int count;
};
NamedDistortion name_of(const CameraCalibration& c) {
  switch (c.distortion) {
    case Distortion::rational:
      return {"rational_polynomial", "rational_polynomial", 8};
    case Distortion::equidistant:
      return {"equidistant", "equidistant", 4};
    case Distortion::thin_prism:
      return {"thin_prism", "thin_prism", 14};
    case Distortion::unified:
      return {"omni", "omni", 5};
    case Distortion::extended_unified:
      return {"eucm", "eucm", 2};
    case Distortion::double_sphere:
      return {"ds", "ds", 2};
    case Distortion::none:
    case Distortion::plumb_bob:
      break;
  }
  return {"radial-tangential", "plumb_bob", c.coefficients[4] != 0.0 ? 5 : 4};
}

// All terms that a model can have, in the files' order.
std::vector<double> terms_of(const CameraCalibration& c) {
  std::vector<double> out(c.coefficients.begin(), c.coefficients.end());
  out.insert(out.end(), c.prism.begin(), c.prism.end());
  return out;
}

// One camera's sensor.yaml. T_BS: this camera in the body, for which the rectified left camera stands.
std::string euroc_sensor(const CameraCalibration& c, const RigidTransform& T_body_camera, double rate_hz) {
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rows += fmt::format("{}, ", T_body_camera.R(i, j));
    rows += fmt::format("{},\n         ", T_body_camera.t[i]);
  }
  const NamedDistortion distortion = name_of(c);
  const double camera[4] = {c.fx_px, c.fy_px, c.cx_px, c.cy_px};
  return fmt::format(
      "sensor_type: camera\n"
      "comment: written by cliquevo\n"
      "T_BS:\n"
      "  cols: 4\n"
      "  rows: 4\n"
      "  data: [{}0, 0, 0, 1]\n"
      "rate_hz: {:g}\n"
      "resolution: [{}, {}]\n"
      "camera_model: pinhole\n"
      "intrinsics: {}\n"
      "distortion_model: {}\n"
      "distortion_coefficients: {}\n",
      rows, rate_hz, c.width, c.height, numbers(camera, 4), distortion.euroc,
      numbers(terms_of(c).data(), distortion.count));
}

}  // namespace

Result<void> write_picture(const std::string& path, ImageView<const std::uint8_t> grey) {
  return write_png(path, drivers::encode_png(grey));
}
Result<void> write_picture(const std::string& path, ImageView<const std::uint16_t> grey) {
  return write_png(path, drivers::encode_png(grey));
}

Result<void> write_text(const std::string& path, const std::string& text) {
  auto file = OutputFile::open(path, fs::path(path).filename().string());
  if (!file) return file.error();
  return file->write(text);
}

std::string kitti_calibration(const StereoModel& m) {
  const auto line = [&](int camera, double cx, double shift) {
    return fmt::format("P{}: {:.17g} 0 {:.17g} {:.17g} 0 {:.17g} {:.17g} 0 0 0 1 0\n", camera, m.fx_px, cx, shift,
                       m.fy_px, m.cy_px);
  };
  return line(0, m.cx_px, 0.0) + line(1, m.cx_px + m.doffs_px, -m.fx_px * m.baseline_m);
}

std::string ros_camera_info(const StereoCalibration& calibration, bool left) {
  const CameraCalibration& c = left ? calibration.left : calibration.right;
  const PrescribedRectification p = calibration.prescribed.value_or(PrescribedRectification{});
  const StereoModel& m = p.model;
  const double K[9] = {c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1};
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = left ? p.R_left : p.R_right;
  const double shift = left ? 0.0 : -m.fx_px * m.baseline_m;
  const double P[12] = {m.fx_px, 0, m.cx_px + (left ? 0.0 : m.doffs_px), shift, 0, m.fy_px, m.cy_px, 0, 0, 0, 1, 0};
  const NamedDistortion distortion = name_of(c);
  const bool plumb_bob = c.distortion == Distortion::plumb_bob || c.distortion == Distortion::none;
  const int count = plumb_bob ? 5 : distortion.count;
  const std::vector<double> terms = terms_of(c);
  const auto matrix = [](const char* name, int rows, int cols, const double* data) {
    return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", name, rows, cols, numbers(data, rows * cols));
  };
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", c.width, c.height,
                     left ? "left" : "right") +
         matrix("camera_matrix", 3, 3, K) + fmt::format("distortion_model: {}\n", distortion.ros) +
         matrix("distortion_coefficients", 1, count, terms.data()) + matrix("rectification_matrix", 3, 3, R.data()) +
         matrix("projection_matrix", 3, 4, P);
}

Result<RecordingFolder> RecordingFolder::create(const std::string& folder, FolderLayout layout,
                                                const StereoCalibration& calibration, double rate_hz) {
  RecordingFolder r;
  r.folder_ = folder;
  r.layout_ = layout;
  r.calibration_ = calibration;
  r.rate_hz_ = rate_hz;
  std::error_code error;
  if (fs::exists(folder, error) && !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    return Error{"cannot write recording", folder, "it is not an empty folder: name a new one or remove it"};
  const bool euroc = layout == FolderLayout::euroc;
  for (const char* name : {euroc ? "mav0/cam0/data" : "image_0", euroc ? "mav0/cam1/data" : "image_1"}) {
    fs::create_directories(fs::path(folder) / name, error);
    if (error) return Error{"cannot write recording", folder, error.message() + ": name a folder that can be written"};
  }
  return r;
}

Result<void> RecordingFolder::add(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                                  TimestampNs stamp_ns) {
  const bool euroc = layout_ == FolderLayout::euroc;
  const std::string name = euroc ? fmt::format("{}", stamp_ns) : fmt::format("{:06d}", count_);
  const char* left_folder = euroc ? "mav0/cam0/data" : "image_0";
  const char* right_folder = euroc ? "mav0/cam1/data" : "image_1";
  if (auto ok = write_picture(fmt::format("{}/{}/{}.png", folder_, left_folder, name), left); !ok) return ok;
  if (auto ok = write_picture(fmt::format("{}/{}/{}.png", folder_, right_folder, name), right); !ok) return ok;
  constexpr std::int64_t kSecond = 1'000'000'000;
  times_ += euroc ? fmt::format("{},{}.png\n", stamp_ns, name)
                  : fmt::format("{}.{:09d}\n", stamp_ns / kSecond, stamp_ns % kSecond);
  ++count_;
  return {};
}

Result<void> RecordingFolder::finish() {
  const StereoCalibration& c = calibration_;
  if (layout_ == FolderLayout::kitti) {
    if (auto ok = write_text(folder_ + "/times.txt", times_); !ok) return ok;
    return write_text(folder_ + "/calib.txt", kitti_calibration(c.prescribed->model));
  }
  RigidTransform T_body_left;
  if (c.prescribed && !c.rectified) T_body_left.R = c.prescribed->R_left;
  const RigidTransform T_body_right = T_body_left * c.T_right_left.inverse();
  for (const bool left : {true, false}) {
    const std::string camera_folder = folder_ + (left ? "/mav0/cam0" : "/mav0/cam1");
    if (auto ok = write_text(camera_folder + "/data.csv", "#timestamp [ns],filename\n" + times_); !ok) return ok;
    const std::string sensor = euroc_sensor(left ? c.left : c.right, left ? T_body_left : T_body_right, rate_hz_);
    if (auto ok = write_text(camera_folder + "/sensor.yaml", sensor); !ok) return ok;
  }
  return {};
}

}  // namespace cliquevo::tools
