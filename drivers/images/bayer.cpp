// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/bayer.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::drivers {

namespace {

constexpr int kBlock = 16;  // px a side
// 260 grey images reach 0.4 of their texture and 0.015 of their brightness, their diagonals differ by up to 1.3: none
// is taken. Of 984 mosaics, made of 123 colour images in every pattern, 955 are found; the others are almost grey.
constexpr double kClear = 1.5;            // between the diagonals, beside texture
constexpr double kClearWithOther = 0.35;  // enough where red and blue differ as well
constexpr double kOtherDiagonal = 1.9;    // how much more than the green pixels do red and blue differ
constexpr double kLeastOfLight = 0.02;
constexpr double kLeastLevels = 1.5;

struct Cell {
  int sums[4] = {0, 0, 0, 0};  // upper left, upper right, lower left, lower right
};

Cell sum_block(ImageView<const std::uint8_t> image, int x0, int y0) {
  Cell out;
  for (int y = 0; y < kBlock; y += 2) {
    const std::uint8_t* upper = image.row(y0 + y) + x0;
    const std::uint8_t* lower = image.row(y0 + y + 1) + x0;
    for (int x = 0; x < kBlock; x += 2) {
      out.sums[0] += upper[x];
      out.sums[1] += upper[x + 1];
      out.sums[2] += lower[x];
      out.sums[3] += lower[x + 1];
    }
  }
  return out;
}

}  // namespace

void MosaicEvidence::add(ImageView<const std::uint8_t> image) {
  constexpr double kOfEach = 0.25 * kBlock * kBlock;
  for (int y = 0; y + kBlock <= image.height; y += kBlock) {
    for (int x = 0; x + kBlock <= image.width; x += kBlock) {
      const Cell cell = sum_block(image, x, y);
      const double down = (cell.sums[0] - cell.sums[3]) / kOfEach;
      const double up = (cell.sums[1] - cell.sums[2]) / kOfEach;
      const double across = (cell.sums[0] + cell.sums[3] - cell.sums[1] - cell.sums[2]) / (2 * kOfEach);
      down_ += down * down;
      up_ += up * up;
      across_ += across * across;
      light_ += (cell.sums[0] + cell.sums[1] + cell.sums[2] + cell.sums[3]) / (4 * kOfEach);
      ++blocks_;
    }
  }
}

bool MosaicEvidence::is_mosaic() const {
  if (blocks_ == 0) return false;
  const double n = static_cast<double>(blocks_);
  const double green = std::sqrt(std::min(down_, up_) / n);  // texture: both pixels see the same colour
  const double other = std::sqrt(std::max(down_, up_) / n);
  const double across = std::sqrt(across_ / n);
  if (across < kLeastLevels || across < kLeastOfLight * light_ / n) return false;
  return across > kClear * green || (across > kClearWithOther * green && other > kOtherDiagonal * green);
}

void MosaicToGrey::convert(ImageView<std::uint8_t> image) {
  const int w = image.width;
  const int h = image.height;
  if (w < 2 || h < 2) return;
  // At the border the row or column inside stands in: it has the colours of the one outside.
  const auto sum_row = [&](int y) {
    std::vector<std::uint16_t>& out = rows_[y % 3];
    out.resize(static_cast<std::size_t>(w));
    const std::uint8_t* row = image.row(y);
    for (int x = 1; x + 1 < w; ++x) {
      out[static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(row[x - 1] + 2 * row[x] + row[x + 1]);
    }
    out.front() = static_cast<std::uint16_t>(2 * row[0] + 2 * row[1]);
    out.back() = static_cast<std::uint16_t>(2 * row[w - 1] + 2 * row[w - 2]);
  };
  sum_row(0);
  for (int y = 0; y < h; ++y) {
    if (y + 1 < h) sum_row(y + 1);  // before row y is written; its own sums are there
    const std::uint16_t* middle = rows_[y % 3].data();
    const std::uint16_t* below = rows_[(y + 1 < h ? y + 1 : y - 1) % 3].data();
    const std::uint16_t* above = rows_[(y > 0 ? y - 1 : y + 1) % 3].data();
    std::uint8_t* to = image.row(y);
    for (int x = 0; x < w; ++x) to[x] = static_cast<std::uint8_t>((above[x] + 2 * middle[x] + below[x] + 8) >> 4);
  }
}

}  // namespace cliquevo::drivers
