// SPDX-License-Identifier: BSD-3-Clause
#include "tools/simulated_recording.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "tools/output_file.h"

namespace cliquevo::tools {

namespace fs = std::filesystem;

namespace {

Result<void> write_image(const std::string& path, const cv::Mat& image) {
  bool written = false;
  try {
    // Fast compression: the pictures are noisy, more effort gains nothing.
    written = cv::imwrite(path, image, {cv::IMWRITE_PNG_COMPRESSION, 1});
  } catch (const cv::Exception&) {  // said below
  }
  if (!written) return Error{"cannot write image", path, "check the folder's permissions and the space left"};
  return {};
}

Result<void> write_text(const std::string& path, const std::string& text) {
  auto file = OutputFile::open(path, fs::path(path).filename().string());
  if (!file) return file.error();
  return file->write(text);
}

cv::Mat wrap(const Image<std::uint8_t>& image) {
  const auto v = image.view();
  return {v.height, v.width, CV_8U, const_cast<std::uint8_t*>(v.data), static_cast<std::size_t>(v.stride)};
}

// P0 and P1 of the rectified pair, as KITTI's calib.txt.
std::string kitti_calibration(const StereoModel& m) {
  const auto line = [&](int camera, double cx, double shift) {
    return fmt::format("P{}: {:.12e} 0 {:.12e} {:.12e} 0 {:.12e} {:.12e} 0 0 0 1 0\n", camera, m.fx_px, cx, shift,
                       m.fy_px, m.cy_px);
  };
  return line(0, m.cx_px, 0.0) + line(1, m.cx_px + m.doffs_px, -m.fx_px * m.baseline_m);
}

// One eye's sensor.yaml. T_BS: this camera in the body, for which the rectified left camera stands.
std::string euroc_sensor(const CameraCalibration& c, const RigidTransform& T_body_camera, double rate_hz) {
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rows += fmt::format("{:.15g}, ", T_body_camera.R(i, j));
    rows += fmt::format("{:.15g},\n         ", T_body_camera.t[i]);
  }
  return fmt::format(
      "sensor_type: camera\n"
      "comment: simulated\n"
      "T_BS:\n"
      "  cols: 4\n"
      "  rows: 4\n"
      "  data: [{}0, 0, 0, 1]\n"
      "rate_hz: {:g}\n"
      "resolution: [{}, {}]\n"
      "camera_model: pinhole\n"
      "intrinsics: [{:.12g}, {:.12g}, {:.12g}, {:.12g}]\n"
      "distortion_model: radial-tangential\n"
      "distortion_coefficients: [{:.12g}, {:.12g}, {:.12g}, {:.12g}]\n",
      rows, rate_hz, c.width, c.height, c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.coefficients[0], c.coefficients[1],
      c.coefficients[2], c.coefficients[3]);
}

}  // namespace

cv::Mat disparity_to_file_units(ImageView<const float> disparity) {
  cv::Mat out(disparity.height, disparity.width, CV_16U);
  for (int y = 0; y < disparity.height; ++y) {
    auto* row = out.ptr<std::uint16_t>(y);
    for (int x = 0; x < disparity.width; ++x) {
      const float d = disparity(x, y) * 256.0F;
      row[x] = d >= 0.5F && d <= 65535.0F ? static_cast<std::uint16_t>(std::lround(d)) : std::uint16_t{0};
    }
  }
  return out;
}

Result<SimulatedRecording> SimulatedRecording::create(const std::string& folder, const StereoCalibration& calibration,
                                                      double rate_hz) {
  SimulatedRecording r;
  r.folder_ = folder;
  r.calibration_ = calibration;
  r.rate_hz_ = rate_hz;
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error))
    return Error{"cannot write recording", folder, "it is not an empty folder: name a new one or remove it"};
  const bool raw = !calibration.rectified;
  for (const char* name : {raw ? "mav0/cam0/data" : "image_0", raw ? "mav0/cam1/data" : "image_1", "disp_0"}) {
    fs::create_directories(fs::path(folder) / name, error);
    if (error) return Error{"cannot write recording", folder, error.message() + ": name a folder that can be written"};
  }
  return r;
}

Result<void> SimulatedRecording::add(const drivers::StereoPair& pair, ImageView<const float> disparity) {
  const bool raw = !calibration_.rectified;
  if (count_ == 0) first_stamp_ns_ = pair.stamp_ns;
  const std::string number = fmt::format("{:06d}", count_);
  const std::string name = raw ? fmt::format("{}", pair.stamp_ns) : number;
  const std::string left = raw ? "mav0/cam0/data/" : "image_0/";
  const std::string right = raw ? "mav0/cam1/data/" : "image_1/";
  if (auto ok = write_image(fmt::format("{}/{}{}.png", folder_, left, name), wrap(pair.left)); !ok) return ok;
  if (auto ok = write_image(fmt::format("{}/{}{}.png", folder_, right, name), wrap(pair.right)); !ok) return ok;
  if (auto ok = write_image(fmt::format("{}/disp_0/{}.png", folder_, number), disparity_to_file_units(disparity)); !ok)
    return ok;
  const RigidTransform T = pair.truth_T_world_camera.value_or(RigidTransform{});
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) poses_ += fmt::format("{:.12g} ", T.R(i, j));
    poses_ += fmt::format("{:.12g}{}", T.t[i], i < 2 ? " " : "\n");
  }
  times_ += raw ? fmt::format("{},{}.png\n", pair.stamp_ns, name)
                : fmt::format("{:.9e}\n", static_cast<double>(pair.stamp_ns - first_stamp_ns_) * 1e-9);
  ++count_;
  return {};
}

Result<void> SimulatedRecording::finish() {
  const StereoCalibration& c = calibration_;
  if (auto ok = write_text(folder_ + "/poses.txt", poses_); !ok) return ok;
  if (c.rectified) {
    if (auto ok = write_text(folder_ + "/times.txt", times_); !ok) return ok;
    return write_text(folder_ + "/calib.txt", kitti_calibration(c.prescribed->model));
  }
  RigidTransform T_body_left;
  T_body_left.R = c.prescribed->R_left;
  const RigidTransform T_body_right = T_body_left * c.T_right_left.inverse();
  for (const bool left : {true, false}) {
    const std::string eye = folder_ + (left ? "/mav0/cam0" : "/mav0/cam1");
    if (auto ok = write_text(eye + "/data.csv", "#timestamp [ns],filename\n" + times_); !ok) return ok;
    const std::string sensor = euroc_sensor(left ? c.left : c.right, left ? T_body_left : T_body_right, rate_hz_);
    if (auto ok = write_text(eye + "/sensor.yaml", sensor); !ok) return ok;
  }
  // The pinhole pair to which disp_0 belongs; a rectification of one's own may choose another.
  return write_text(folder_ + "/disp_0/calib.txt", kitti_calibration(c.prescribed->model));
}

}  // namespace cliquevo::tools
