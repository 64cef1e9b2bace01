// SPDX-License-Identifier: BSD-3-Clause
#include "tools/picture.h"

#include <algorithm>
#include <cmath>

#include "drivers/images/png_writer.h"

namespace cliquevo::tools {

Picture::Picture(int width, int height, Color color) : bytes_(3 * width, height) {
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) set(x, y, color);
  }
}

void Picture::put(const Picture& other, int left, int top) {
  for (int y = std::max(0, -top); y < other.height() && top + y < height(); ++y) {
    for (int x = std::max(0, -left); x < other.width() && left + x < width(); ++x) {
      set(left + x, top + y, other.at(x, y));
    }
  }
}

Picture Picture::shrunk(int w, int h) const {
  Picture out(w, h, {});
  for (int y = 0; y < h; ++y) {
    const int top = y * height() / h;
    const int bottom = std::max(top + 1, (y + 1) * height() / h);
    for (int x = 0; x < w; ++x) {
      const int left = x * width() / w;
      const int right = std::max(left + 1, (x + 1) * width() / w);
      int sums[3] = {0, 0, 0};
      for (int sy = top; sy < bottom; ++sy) {
        for (int sx = left; sx < right; ++sx) {
          const Color c = at(sx, sy);
          sums[0] += c.red, sums[1] += c.green, sums[2] += c.blue;
        }
      }
      const int count = (bottom - top) * (right - left);
      const auto mean = [count](int sum) { return static_cast<std::uint8_t>((sum + count / 2) / count); };
      out.set(x, y, {mean(sums[0]), mean(sums[1]), mean(sums[2])});
    }
  }
  return out;
}

Result<std::vector<unsigned char>> Picture::png() const { return drivers::encode_png_rgb(bytes_.cview()); }

Color rainbow(double value) {
  // The colour map "Turbo", as the polynomials that its authors fitted to it.
  const double v = std::clamp(value, 0.0, 1.0);
  const auto polynomial = [v](const double(&c)[6]) {
    double sum = 0.0;
    for (int i = 5; i >= 0; --i) sum = sum * v + c[i];
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(sum, 0.0, 1.0)));
  };
  return {polynomial({0.13572138, 4.61539260, -42.66032258, 132.13108234, -152.94239396, 59.28637943}),
          polynomial({0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604}),
          polynomial({0.10667330, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973})};
}

}  // namespace cliquevo::tools
