// SPDX-License-Identifier: BSD-3-Clause
#include "tools/simulated_recording.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "tools/recording_folder.h"

namespace cliquevo::tools {

namespace fs = std::filesystem;

Image<std::uint16_t> disparity_to_file_units(ImageView<const float> disparity) {
  Image<std::uint16_t> out(disparity.width, disparity.height);
  for (int y = 0; y < disparity.height; ++y) {
    std::uint16_t* row = out.view().row(y);
    for (int x = 0; x < disparity.width; ++x) {
      const float d = disparity(x, y) * 256.0F;
      row[x] = d >= 0.5F && d <= 65535.0F ? static_cast<std::uint16_t>(std::lround(d)) : std::uint16_t{0};
    }
  }
  return out;
}

Result<SimulatedRecording> SimulatedRecording::create(const std::string& folder, const StereoCalibration& calibration,
                                                      double rate_hz) {
  const FolderLayout layout = calibration.rectified ? FolderLayout::kitti : FolderLayout::euroc;
  auto images = RecordingFolder::create(folder, layout, calibration, rate_hz);
  if (!images) return images.error();
  std::error_code error;
  fs::create_directories(fs::path(folder) / "disp_0", error);
  if (error) return Error{"cannot write recording", folder, error.message() + ": name a folder that can be written"};
  return SimulatedRecording(folder, calibration, std::move(*images));
}

Result<void> SimulatedRecording::add(const drivers::StereoPair& pair, ImageView<const float> disparity) {
  if (count_ == 0) first_stamp_ns_ = pair.stamp_ns;
  const TimestampNs stamp_ns = calibration_.rectified ? pair.stamp_ns - first_stamp_ns_ : pair.stamp_ns;
  if (auto ok = images_.add(pair.left.cview(), pair.right.cview(), stamp_ns); !ok) return ok;
  const std::string picture = fmt::format("{}/disp_0/{:06d}.png", folder_, count_);
  if (auto ok = write_picture(picture, disparity_to_file_units(disparity).cview()); !ok) return ok;
  const RigidTransform T = pair.truth_T_world_camera.value_or(RigidTransform{});
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) poses_ += fmt::format("{:.12g} ", T.R(i, j));
    poses_ += fmt::format("{:.12g}{}", T.t[i], i < 2 ? " " : "\n");
  }
  ++count_;
  return {};
}

Result<void> SimulatedRecording::finish() {
  if (auto ok = write_text(folder_ + "/poses.txt", poses_); !ok) return ok;
  if (auto ok = images_.finish(); !ok) return ok;
  if (calibration_.rectified) return {};
  // The pinhole pair to which disp_0 belongs; a rectification of one's own may choose another.
  return write_text(folder_ + "/disp_0/calib.txt", kitti_calibration(calibration_.prescribed->model));
}

}  // namespace cliquevo::tools
