// SPDX-License-Identifier: BSD-3-Clause
// Once set up, rectifying and matching take no memory from the system: every `new` of this program is counted.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"

namespace {

std::atomic<long> taken{0};

void* take(std::size_t size, std::size_t alignment) {
  taken.fetch_add(1);
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  void* p = std::aligned_alloc(alignment, whole == 0 ? alignment : whole);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

}  // namespace

// g++ sees what was allocated here freed here, and not that both are the program's own.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(std::size_t size) { return take(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return take(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t /*size*/) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t /*alignment*/) noexcept { std::free(p); }
void operator delete(void* p, std::size_t /*size*/, std::align_val_t /*alignment*/) noexcept { std::free(p); }

namespace cliquevo::stereo {
namespace {

void fill_with_noise(ImageView<std::uint8_t> image, unsigned seed) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      seed = seed * 1664525U + 1013904223U;
      image(x, y) = static_cast<std::uint8_t>(seed >> 24);
    }
  }
}

TEST(DenseStereo, TakesNoMemoryOnceItIsSetUp) {
  const int w = 211;
  const int h = 90;
  Image<std::uint8_t> left(w, h), right(w, h), filtered(w, h);
  Image<std::int16_t> disparity(w, h);
  for (const int workers : {1, 3}) {
    for (const Prefilter prefilter : {Prefilter::gradients, Prefilter::xsobel, Prefilter::none}) {
      StereoParams p;
      p.prefilter = prefilter;
      p.workers = workers;
      p.num_disparities = 64;
      auto stereo = DenseStereo::make(p, w, h);
      ASSERT_TRUE(stereo.ok());
      for (unsigned frame = 0; frame < 6; ++frame) {
        // The same picture twice is full of matches; two noises are full of speckles.
        fill_with_noise(left.view(), frame);
        fill_with_noise(right.view(), frame % 2 == 0 ? frame : frame + 77);
        const long before = taken.load();
        const bool ok = stereo->compute(left.view(), right.view(), filtered.view(), disparity.view()).ok();
        const long after = taken.load();
        EXPECT_TRUE(ok);
        EXPECT_EQ(after, before) << workers << " workers, frame " << frame;
      }
    }
  }
}

TEST(Rectifier, TakesNoMemoryOnceItIsSetUp) {
  StereoCalibration c;
  for (CameraCalibration* camera : {&c.left, &c.right}) {
    *camera = {320, 240, 260, 260, 160, 120, Distortion::plumb_bob, {-0.3, 0.1}};
  }
  c.T_right_left.t = {-0.1, 0.0, 0.0};
  const auto rectifier = Rectifier::make(c);
  ASSERT_TRUE(rectifier.ok()) << rectifier.error().line();
  Image<std::uint8_t> raw(320, 240), out(rectifier->model().width, rectifier->model().height);
  fill_with_noise(raw.view(), 1);
  const long before = taken.load();
  const bool ok = rectifier->rectify(CameraSide::left, raw.view(), out.view()).ok() &&
                  rectifier->rectify_mask(CameraSide::right, raw.view(), out.view()).ok();
  const long after = taken.load();
  EXPECT_TRUE(ok);
  EXPECT_EQ(after, before);
}

}  // namespace
}  // namespace cliquevo::stereo
