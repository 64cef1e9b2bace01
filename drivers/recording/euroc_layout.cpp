// SPDX-License-Identifier: BSD-3-Clause
// EuRoC folders: mav0/cam0 and mav0/cam1 with data.csv, sensor.yaml and data/; the mav0 folder itself will do.
#include <filesystem>

#include "drivers/calibration/calibration.h"
#include "drivers/recording/layout.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

Result<std::optional<Layout>> find_euroc(const std::string& path) {
  std::error_code ec;
  fs::path root(path);
  if (fs::is_directory(root / "mav0", ec)) root /= "mav0";
  const auto is_camera = [&](const char* name) {
    const fs::path camera = root / name;
    return fs::is_directory(camera / "data", ec) || fs::exists(camera / "data.csv", ec) ||
           fs::exists(camera / "sensor.yaml", ec);
  };
  if (!is_camera("cam0") && !is_camera("cam1")) return std::optional<Layout>{};
  Layout layout;
  layout.description = "EuRoC folder " + path;
  layout.root = path;
  // Some leave the images beside the list, or in a folder of another name, instead of below data/.
  const auto images = [&](const char* name) {
    const fs::path camera = root / name;
    if (fs::is_directory(camera / "data", ec) || !fs::is_directory(camera, ec)) return (camera / "data").string();
    const std::vector<ImageFolder> folders = folders_with_images(camera.string(), 1);
    return folders.empty() ? camera.string() : folders.front().path;
  };
  if (const auto ok = list_both_sides(layout, images("cam0"), images("cam1")); !ok) return ok.error();
  if (const auto ok = find_stamps(layout, path); !ok) return ok.error();
  if (fs::exists(root / "cam0/sensor.yaml", ec) || fs::exists(root / "cam1/sensor.yaml", ec)) {
    layout.calibration = (root / "cam0/sensor.yaml").string();
  } else {
    layout.calibration = find_calibration(path);
    if (layout.calibration.empty()) layout.calibration = find_calibration(root.string());
  }
  return std::optional<Layout>(std::move(layout));
}

}  // namespace cliquevo::drivers
