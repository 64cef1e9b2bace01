// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/usable_area.h"

namespace cliquevo::stereo {

Result<Image<std::uint8_t>> usable_area(const Rectifier& rectifier, CameraSide side, ImageView<const std::uint8_t> mask,
                                        const CameraCalibration& raw) {
  Image<std::uint8_t> everything;
  if (mask.empty()) {
    everything.resize(raw.width, raw.height);
    everything.fill(255);
    mask = everything.cview();
  }
  Image<std::uint8_t> area(rectifier.model().width, rectifier.model().height);
  if (auto ok = rectifier.rectify_mask(side, mask, area.view()); !ok) return ok.error();
  const ImageView<const std::uint8_t> view = area.cview();
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (view(x, y) == 0) return area;
    }
  }
  return Image<std::uint8_t>{};
}

void drop_unusable(ImageView<const std::uint8_t> right_area, ImageView<std::int16_t> disparity) {
  constexpr int kHalf = kDisparityScale / 2;
  for (int y = 0; y < disparity.height; ++y) {
    std::int16_t* d = disparity.row(y);
    const std::uint8_t* usable = right_area.row(y);
    for (int x = 0; x < disparity.width; ++x) {
      if (d[x] == kUnknownDisparity) continue;
      const int right_x = x - ((d[x] + kHalf) >> 4);
      if (right_x >= 0 && right_x < disparity.width && usable[right_x] == 0) d[x] = kUnknownDisparity;
    }
  }
}

}  // namespace cliquevo::stereo
