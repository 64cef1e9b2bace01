// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/dense_stereo.h"

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "stereo/speckles.h"

namespace cliquevo::stereo {
namespace {

// A textured plane: right image sampled from a smooth random signal, shifted by a sub-pixel disparity per row band.
struct Scene {
  Image<std::uint8_t> left, right;
  std::vector<double> disparity_px;  // per row
};

Scene slanted(int width, int height, double first, double last) {
  Scene s;
  s.left.resize(width, height);
  s.right.resize(width, height);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> phase(0.0, 6.283);
  for (int y = 0; y < height; ++y) {
    const double d = first + (last - first) * y / height;
    s.disparity_px.push_back(d);
    std::mt19937 row_random(static_cast<unsigned>(y / 3 + 1));
    std::vector<double> ph, fr;
    for (int k = 0; k < 12; ++k) {
      ph.push_back(phase(row_random));
      fr.push_back(0.08 + 0.09 * k);
    }
    const auto value = [&](double x) {
      double v = 128.0;
      for (int k = 0; k < 12; ++k) v += 14.0 * std::sin(fr[k] * x + ph[k]);
      return static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, v))));
    };
    for (int x = 0; x < width; ++x) {
      s.left.view()(x, y) = value(x);
      s.right.view()(x, y) = value(x + d);
    }
  }
  return s;
}

TEST(DenseStereo, SharesTheRowsOverWorkersWithoutAChangeInTheResult) {
  const int w = 200;
  const int h = 97;
  const Scene s = slanted(w, h, 5.0, 30.0);
  StereoParams p;
  p.num_disparities = 48;
  std::vector<std::int16_t> alone;
  for (const int workers : {1, 2, 3, 7, 64}) {
    p.workers = workers;
    auto stereo = DenseStereo::make(p, w, h);
    ASSERT_TRUE(stereo.ok());
    Image<std::uint8_t> filtered(w, h);
    Image<std::int16_t> disparity(w, h);
    for (int again = 0; again < 20; ++again) {
      disparity.fill(7);
      ASSERT_TRUE(stereo->compute(s.left.view(), s.right.view(), filtered.view(), disparity.view()).ok());
      std::vector<std::int16_t> found;
      for (int y = 0; y < h; ++y) found.insert(found.end(), disparity.cview().row(y), disparity.cview().row(y) + w);
      if (alone.empty()) alone = found;
      ASSERT_EQ(found, alone) << workers << " workers, call " << again;
    }
  }
}

TEST(DenseStereo, FindsASlantedPlaneToAFractionOfAPixel) {
  const int w = 320;
  const int h = 120;
  const Scene s = slanted(w, h, 5.0, 30.0);
  StereoParams p;
  p.num_disparities = 64;
  auto stereo = DenseStereo::make(p, w, h);
  ASSERT_TRUE(stereo.ok());
  Image<std::uint8_t> filtered(w, h);
  Image<std::int16_t> disparity(w, h);
  ASSERT_TRUE(stereo->compute(s.left.view(), s.right.view(), filtered.view(), disparity.view()).ok());
  int known = 0;
  int right = 0;
  for (int y = 8; y < h - 8; ++y) {
    for (int x = 80; x < w - 8; ++x) {
      const int d = disparity.view()(x, y);
      if (d == kUnknownDisparity) continue;
      ++known;
      right += std::abs(d / 16.0 - s.disparity_px[y]) < 0.5;
    }
  }
  EXPECT_GT(known, 0.8 * (h - 16) * (w - 88));
  EXPECT_GT(right, 0.98 * known);
}

TEST(DenseStereo, FindsFarPointsBelowZeroOfASlightlyWrongCalibration) {
  const int w = 200;
  const int h = 40;
  const Scene s = slanted(w, h, -1.0, -0.6);
  StereoParams p;
  p.num_disparities = 32;
  auto stereo = DenseStereo::make(p, w, h);
  ASSERT_TRUE(stereo.ok());
  Image<std::uint8_t> filtered(w, h);
  Image<std::int16_t> disparity(w, h);
  ASSERT_TRUE(stereo->compute(s.left.view(), s.right.view(), filtered.view(), disparity.view()).ok());
  int known = 0;
  for (int x = 60; x < w - 20; ++x) {
    const int d = disparity.view()(x, h / 2);
    if (d == kUnknownDisparity) continue;
    ++known;
    EXPECT_NEAR(d / 16.0, -0.8, 0.4);
  }
  EXPECT_GT(known, 80);
}

TEST(DenseStereo, LeavesAFlatPairUnknown) {
  const int w = 160;
  const int h = 40;
  Image<std::uint8_t> grey(w, h);
  grey.fill(90);
  StereoParams p;
  p.num_disparities = 32;
  auto stereo = DenseStereo::make(p, w, h);
  ASSERT_TRUE(stereo.ok());
  Image<std::uint8_t> filtered(w, h);
  Image<std::int16_t> disparity(w, h);
  disparity.fill(5);
  ASSERT_TRUE(stereo->compute(grey.view(), grey.view(), filtered.view(), disparity.view()).ok());
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) ASSERT_EQ(disparity.view()(x, y), kUnknownDisparity);
  }
}

TEST(DenseStereo, NamesBadCallsBeforeAnyWork) {
  StereoParams p;
  EXPECT_TRUE(p.check().ok());
  EXPECT_FALSE(DenseStereo::make(p, 100, 100).ok());  // disparities beyond the width
  p.num_disparities = 32;
  EXPECT_FALSE(DenseStereo::make(p, 100, 5).ok());  // window larger than the image
  EXPECT_FALSE(DenseStereo::make(p, 0, 5).ok());
  for (const auto& spoil : std::initializer_list<void (*)(StereoParams&)>{
           [](StereoParams& q) { q.window = 8; }, [](StereoParams& q) { q.window = 23; },
           [](StereoParams& q) { q.num_disparities = 40; }, [](StereoParams& q) { q.num_disparities = 512; },
           [](StereoParams& q) { q.workers = 0; }, [](StereoParams& q) { q.prefilter_cap = 64; }}) {
    StereoParams q = p;
    spoil(q);
    ASSERT_FALSE(q.check().ok());
    EXPECT_FALSE(q.check().error().where.empty());
    EXPECT_FALSE(DenseStereo::make(q, 640, 480).ok());
  }
  auto stereo = DenseStereo::make(p, 100, 60);
  ASSERT_TRUE(stereo.ok());
  Image<std::uint8_t> l(100, 60), r(100, 60), f(100, 60), small(99, 60);
  Image<std::int16_t> d(100, 60);
  d.fill(77);
  const auto refused = [&](ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                           ImageView<std::uint8_t> filtered, ImageView<std::int16_t> disparity) {
    const auto result = stereo->compute(left, right, filtered, disparity);
    return result.ok() ? std::string() : result.error().line();
  };
  const auto names = [](const std::string& error, const char* what) {
    return error.find(what) != std::string::npos && error.find("cannot match") != std::string::npos;
  };
  EXPECT_TRUE(names(refused({}, r.view(), f.view(), d.view()), "left image is null"));
  EXPECT_TRUE(names(refused(l.view(), {}, f.view(), d.view()), "right image is null"));
  EXPECT_TRUE(names(refused(l.view(), r.view(), {}, d.view()), "filtered image is null"));
  EXPECT_TRUE(names(refused(l.view(), r.view(), f.view(), {}), "disparity image is null"));
  EXPECT_TRUE(names(refused(l.view(), small.view(), f.view(), d.view()), "right image is 99x60"));
  EXPECT_TRUE(names(refused(l.view(), r.view(), l.view(), d.view()), "output view overlaps an input"));
  EXPECT_TRUE(names(refused({l.cview().data, 100, 60, 99}, r.view(), f.view(), d.view()), "rows closer"));
  // The filtered image inside the disparity's memory.
  auto* inside = reinterpret_cast<std::uint8_t*>(d.view().data);
  EXPECT_TRUE(names(refused(l.view(), r.view(), {inside, 100, 60, 100}, d.view()), "output views overlap"));
  EXPECT_EQ(d.view()(50, 30), 77);
}

// The same by flood fill, one pixel at a time.
void flood_speckles(ImageView<std::int16_t> d, int size, int range) {
  std::vector<char> seen(static_cast<std::size_t>(d.width * d.height), 0);
  for (int y = 0; y < d.height; ++y) {
    for (int x = 0; x < d.width; ++x) {
      if (seen[y * d.width + x] || d(x, y) == kUnknownDisparity) continue;
      std::vector<std::pair<int, int>> part{{x, y}};
      seen[y * d.width + x] = 1;
      for (std::size_t i = 0; i < part.size(); ++i) {
        const auto [px, py] = part[i];
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const int qx = px + dx;
          const int qy = py + dy;
          if (!d.contains(qx, qy) || seen[qy * d.width + qx] || d(qx, qy) == kUnknownDisparity) continue;
          if (std::abs(d(qx, qy) - d(px, py)) > range) continue;
          seen[qy * d.width + qx] = 1;
          part.emplace_back(qx, qy);
        }
      }
      if (static_cast<int>(part.size()) < size) {
        for (const auto& [px, py] : part) d(px, py) = kUnknownDisparity;
      }
    }
  }
}

TEST(Speckles, EqualAPlainFloodFill) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    const int w = 1 + static_cast<int>(random() % 200);
    const int h = 1 + static_cast<int>(random() % 40);
    const int levels = 2 + static_cast<int>(random() % 6);
    Image<std::int16_t> a(w, h), b(w, h);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const int v = static_cast<int>(random()) % levels;
        a.view()(x, y) = v == 0 ? kUnknownDisparity : static_cast<std::int16_t>(v * 10);
      }
    }
    b.copy_from(a.view());
    // Any number of workers, however the rows happen to fall to them.
    const int workers = 1 + static_cast<int>(random() % 6);
    RowShares shares(workers, h);
    shares.restart();
    SpeckleFilter filter;
    filter.prepare(w, h, 16, shares);
    for (int i = 0; i < workers; ++i) filter.start(i);
    std::vector<int> next;
    for (int i = 0; i < workers; ++i) next.push_back(shares.first(i));
    std::vector<int> busy(static_cast<std::size_t>(workers));
    std::iota(busy.begin(), busy.end(), 0);
    int added = 0;
    while (!busy.empty()) {
      const std::size_t turn = random() % 3 == 0 ? random() % busy.size() : 0;
      const int worker = busy[turn];
      if (!shares.one_more(worker)) {
        filter.finish(worker);
        busy.erase(busy.begin() + static_cast<std::ptrdiff_t>(turn));
        continue;
      }
      filter.add_row(kernels::active(), worker, a.view(), next[static_cast<std::size_t>(worker)]);
      next[static_cast<std::size_t>(worker)] += RowShares::step(worker);
      ++added;
    }
    ASSERT_EQ(added, h);
    filter.join_seams(kernels::active(), a.view());
    for (int y = 0; y < h; ++y) filter.clean(y, 12, a.view().row(y));
    flood_speckles(b.view(), 12, 16);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) ASSERT_EQ(a.view()(x, y), b.view()(x, y)) << round << ": " << x << "," << y;
    }
  }
}

}  // namespace
}  // namespace cliquevo::stereo
