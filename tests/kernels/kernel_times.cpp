// SPDX-License-Identifier: BSD-3-Clause
// test_stereo_kernels --time: how long each kernel takes on each instruction set this machine has.
#include "tests/kernels/kernel_times.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

constexpr int kWidth = 512;
constexpr int kHeight = 64;

double thread_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e9 * static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec);
}

double least_ns(const std::function<void()>& work) {
  double least = 1e18;
  for (int i = 0; i < 40; ++i) {
    const double begin = thread_ns();
    work();
    least = std::min(least, thread_ns() - begin);
  }
  return least;
}

// A chain of rotations that wait for each other: one a cycle, whatever the machine.
double cycle_ns() {
  constexpr int kSteps = 200000;
  return least_ns([] {
           std::uint64_t x = 1;
           for (int i = 0; i < kSteps; ++i) {
#if defined(__x86_64__)
             __asm__ volatile("ror $7, %0\n\tror $7, %0\n\tror $7, %0\n\tror $7, %0" : "+r"(x));
#elif defined(__aarch64__)
             __asm__ volatile("ror %0, %0, #7\n\tror %0, %0, #7\n\tror %0, %0, #7\n\tror %0, %0, #7" : "+r"(x));
#else
             x += 4;
#endif
           }
         }) /
         (4.0 * kSteps);
}

// Random pictures and rows, and the memory that the kernels work in.
struct Bench {
  int stride = kWidth + 2 * kMargin;
  std::vector<std::uint8_t> matching[3], raw, bytes[2];
  Image<std::uint8_t> columns{static_cast<int>(column_cells(kWidth, 256)), 1};
  Image<std::uint16_t> costs{static_cast<int>(cost_cells(256)), 1};
  std::vector<std::uint16_t> found = std::vector<std::uint16_t>(MatchRow::kRows * MatchRow::kStride);
  std::vector<std::uint16_t> texture_columns, texture;
  std::vector<std::uint32_t> partner;
  std::vector<std::int16_t> astray, disparity[5], out;
  std::vector<std::uint64_t> bits[3];
  std::vector<std::int16_t> map_x, map_y;
  std::vector<std::uint8_t> weights, at;
  std::vector<RemapRow::Patch> patches;

  Bench() {
    std::mt19937 random(1);
    const auto n = static_cast<std::size_t>(kWidth);
    for (auto& m : matching) m.resize(static_cast<std::size_t>(stride * kHeight));
    raw.resize(static_cast<std::size_t>(stride * kHeight));
    for (auto* v : {&matching[0], &matching[1], &matching[2]}) {
      for (auto& p : *v) p = static_cast<std::uint8_t>(random() % 19);
    }
    for (auto& p : raw) p = static_cast<std::uint8_t>(random());
    for (auto& b : bytes) b.resize(n);
    texture_columns.assign(n, 300);
    texture.assign(n, 4000);
    partner.resize(3 * n);
    astray.resize(n);
    out.resize(n);
    for (auto& row : disparity) {
      row.resize(n);
      for (std::size_t x = 0; x < n; ++x) {
        row[x] = random() % 8 == 0 ? kUnknownDisparity : static_cast<std::int16_t>(320 + x / 4 + random() % 6);
      }
    }
    for (auto& b : bits) b.resize(n / 64);
    for (std::size_t x = 0; x < n; ++x) {
      map_x.push_back(static_cast<std::int16_t>(x + x / 8));
      map_y.push_back(static_cast<std::int16_t>(x / 32));
      weights.push_back(static_cast<std::uint8_t>(random() % 64));
      if (x % RemapRow::kBlock == 0) patches.push_back({map_x[x], map_y[x]});
      at.push_back(static_cast<std::uint8_t>(map_x[x] - patches.back().x));
    }
  }

  double match(const Table& kernel, int disparities) {
    MatchJob job{};
    job.left = matching[0].data() + kMargin;
    job.right[0] = matching[1].data() + kMargin;
    job.right[1] = matching[2].data() + kMargin;
    job.stride = stride;
    job.channels = Channels::checkered;
    job.width = kWidth;
    job.height = kHeight;
    job.window = 13;
    job.window_height = 7;
    job.num_disparities = disparities;
    job.second = true;
    job.columns = columns.view().data;
    job.costs = costs.view().data;
    job.out.rows = found.data();
    job.step = 1;
    job.y = 10;
    job.first = true;
    kernel.match_row(job);
    job.first = false;
    return least_ns([&] {
      for (job.y = 11; job.y < 19; ++job.y) kernel.match_row(job);
    });
  }

  double time(const Table& kernel, int which) {
    constexpr int kTimes = 8;
    const MatchRow row{found.data()};
    const PrefilterRow in{
        raw.data(), raw.data() + stride, raw.data() + 2 * stride, kWidth, {{12, 40, 160}, {1345, 446, 86}, 9}};
    const auto repeated = [](const auto& call) {
      return least_ns([&] {
        for (int i = 0; i < kTimes; ++i) call();
      });
    };
    switch (which) {
      case 0:
        return match(kernel, 64);
      case 1:
        return match(kernel, 128);
      case 2:
        return repeated([&] {
          kernel.prefilter_left(in, Channels::checkered, 0, 31, bytes[0].data(), bytes[1].data());
          kernel.prefilter_right(in, bytes[0].data(), bytes[1].data());
        });
      case 3:
        return repeated([&] {
          kernel.texture_columns(raw.data(), raw.data() + 1, 31, kWidth, texture_columns.data());
          kernel.texture_sums(texture_columns.data(), kWidth, 6, texture.data());
        });
      case 4:
        return repeated([&] { kernel.cross_check({row, kWidth, partner.data(), astray.data()}); });
      case 5:
        return repeated([&] {
          kernel.finish_row({row, astray.data(), texture.data(), kWidth, 10, 182, 1}, out.data());
        });
      case 6:
        return repeated([&] {
          kernel.link_row(
              {disparity[0].data(), disparity[1].data(), kWidth, 16, bits[0].data(), bits[1].data(), bits[2].data()});
        });
      case 7:
        return repeated([&] {
          const SmoothRow smooth{disparity[0].data(),
                                 {disparity[1].data(), disparity[2].data(), disparity[3].data(), disparity[4].data()},
                                 4,
                                 16,
                                 4,
                                 0,
                                 0};
          kernel.smooth_row(smooth, kWidth, out.data());
        });
      default:
        return repeated([&] {
          const RemapRow map{map_x.data(), map_y.data(), weights.data(), weights.data(), patches.data(), at.data()};
          kernel.remap_row(raw.data(), stride, map, kWidth, bytes[0].data());
        });
    }
  }
};

}  // namespace

void print_kernel_times() {
  const char* const names[] = {"match, 64 disparities",   "match, 128 disparities",
                               "pre-filter, both images", "texture",
                               "left-right check",        "finish",
                               "links for speckles",      "smooth, one pass",
                               "rectify, one image"};
  const std::vector<Isa> sets = isas();
  Bench bench;
  std::printf("cycles a pixel, %d px wide; one cycle lasts %.3f ns\n| kernel |", kWidth, cycle_ns());
  for (const Isa isa : sets) {
    if (isa_available(isa)) std::printf(" %s |", isa_name(isa));
  }
  std::printf("\n");
  for (int which = 0; which < static_cast<int>(std::size(names)); ++which) {
    std::printf("| %s |", names[which]);
    for (const Isa isa : sets) {
      if (!isa_available(isa)) continue;
      // The clock changes with what runs beside: both are measured in turns, the smallest quotient counts.
      double least = 1e18;
      for (int round = 0; round < 3; ++round) {
        least = std::min(least, bench.time(*tables().find(isa), which) / (8.0 * kWidth) / cycle_ns());
      }
      std::printf(" %.2f |", least);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}

}  // namespace cliquevo::stereo::kernels
