// SPDX-License-Identifier: BSD-3-Clause
// The vectorised inner loops of the odometry: a table of them, which each instruction set overrides by name; all are
// bit-identical to the reference.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/kernel_tables.h"

namespace cliquevo::vo {

// Bytes from one descriptor to the next; unused bytes are 0.
inline constexpr int kDescriptorStride = 128;

// Step A5's observations of one reference frame, one array a quantity; `count` is a multiple of kMotionLanes, the rest
// padded with inactive copies.
inline constexpr int kMotionLanes = 4;
inline constexpr double kBehindCamera = 1e12;  // squared error of a point that comes to lie behind the camera
enum MotionField {
  kQx,
  kQy,
  kQz,  // point of the reference, in the previous camera's frame
  kDx,
  kDy,
  kDz,  // its change with its disparity
  kPx,
  kPy,
  kPz,        // point of the current frame, in its own frame
  kInverseD,  // 1 / (its disparity + doffs)
  kRefU,
  kRefV,
  kRefD,  // observed, px
  kCurU,
  kCurV,
  kCurD,
  kActive,   // 1: counts, 0: does not
  kSquared,  // out: squared sigmas
  kMotionFields
};
struct MotionTerms {
  double* field[kMotionFields];
  int count;
};
struct MotionState {
  double R[3][3], t[3];  // T_prev_cur
  double M[3][3], m[3];  // T_ref_cur
  double fx, fy, cx, cy, fx_baseline, doffs;
  double weight_px, weight_d, variance_d;  // 1 / sigma^2 of positions and disparities, sigma^2 of disparities
  double huber, min_depth;
  double shift;  // taken off the current frame's disparities, px
};
struct MotionSums {
  double H[21];  // upper triangle, row by row, of the perturbation [translation, rotation] on the right
  double g[6];
  double offset_h[6], offset_hh, offset_g;  // the same with an error common to all disparities
  double shift_h[6], shift_hh, shift_g;     // and with one common to those of the current frame alone
  double shift_offset;                      // of these two together
  double cost;
};

// Patches of core/vo/patch.h: (2 r + 3)^2 samples, row by row without gaps; the outermost ring serves the gradients.
inline constexpr int kMaxPatchRadius = 7;
inline constexpr int kMaxPatchSide = 2 * kMaxPatchRadius + 3;
inline constexpr int kPatchLanes = 8;
inline constexpr int kMaxPatchSamples = kMaxPatchSide * kMaxPatchSide + 2 * kPatchLanes;  // whole packs may be written
// Inner part, 2 r + 1 rows padded to whole packs.
inline constexpr int kMaxPatchRow = 2 * kPatchLanes;
inline constexpr int kMaxPatchInner = kMaxPatchRow * (2 * kMaxPatchRadius + 1);

struct PatchGrid {
  int radius;
  int side;                                // 2 r + 3
  int row;                                 // 2 r + 1 rounded up to whole packs
  alignas(32) float dx[kMaxPatchSamples];  // of each sample from the centre
  alignas(32) float dy[kMaxPatchSamples];
  alignas(32) float inside[kMaxPatchRow];  // 1 in the lanes of an inner row, 0 in its padding
};
// Where a patch is in an image: x + xx dx + xy dy, y + yx dx + yy dy.
struct PatchPlace {
  float x, y, xx, xy, yx, yy;
};
// A template's inner part, padded with 0: samples less their mean, and half their central differences.
struct PatchInner {
  float mean;
  float tt;  // sum of the squares of t
  alignas(32) float t[kMaxPatchInner];
  alignas(32) float gx[kMaxPatchInner];
  alignas(32) float gy[kMaxPatchInner];
};
// Sums over the inner part; w: samples of the image, g: mean gradient of template and image.
struct PatchSums {
  float w, ww, tw, gx, gy, gxx, gxy, gyy, gxt, gyt, gxw, gyw;
};

// Step A4's test on the matches' mutual distances, one array a quantity; single precision, as the distances are
// compared with centimetres. Each is readable up to the next multiple of kGraphLanes.
inline constexpr int kGraphLanes = 8;
enum GraphField {
  kAx,
  kAy,
  kAz,  // point in the one frame, m
  kBx,
  kBy,
  kBz,  // in the other
  kRangeAx,
  kRangeAy,
  kRangeAz,  // one sigma along the viewing ray, m
  kRangeBx,
  kRangeBy,
  kRangeBz,
  kLateral,  // variance across it, both frames together, m^2
  kGraphFields
};
struct GraphNodes {
  const float* field[kGraphFields];
  int count;
};
struct GraphTest {
  float least2;   // lengths may differ by so much, m^2, ...
  float sigmas2;  // ... or by so many variances
};

struct Kernels {
  // FAST-9 of one row: pixels x0 <= x < x1 of `row` (3 px of image on every side) with 9 contiguous pixels of the 16 on
  // the circle all brighter than centre + threshold or all darker than centre - threshold. Writes scores[x]: the
  // largest threshold that would still hold, 0 where `threshold` >= 1 does not.
  void (*fast_row)(const std::uint8_t* row, std::ptrdiff_t stride, int x0, int x1, int threshold, std::uint8_t* scores);
  // Columns x0 <= x < x1, rising, whose score is above 0 and no less than those of their eight neighbours (of equals,
  // the first in reading order); returns their number. A column is readable before x0 and behind x1.
  int (*maxima_row)(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int x0, int x1,
                    std::int16_t* columns);
  // Step A2': sums of absolute differences between one descriptor and `count` others, kDescriptorStride bytes apart;
  // `length` bytes each, rounded up to a multiple of 64 (the rest is 0).
  void (*sad_row)(const std::uint8_t* descriptor, const std::uint8_t* others, int count, int length,
                  std::uint16_t* scores);
  // Step A3: the first of the least of `count` > 0 scores of this row; each column's least score and the first row that
  // has it are kept up to date, beginning with 65535 and -1.
  int (*row_minimum)(const std::uint16_t* scores, int count, int row, std::uint16_t* column_score,
                     std::int16_t* column_best);
  // Step A4: which nodes keep their distance to `node`: bit j % 8 of bits[j / 8] for j < count, the rest 0.
  void (*graph_row)(const GraphNodes& nodes, int node, const GraphTest& test, std::uint8_t* bits);
  // A template: bilinear samples `right` and `down` of the pixels from `image` on, both at least 0 and below 1. Whole
  // packs of each row and one byte more are readable, in one row more.
  void (*patch_cut)(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, float right, float down,
                    PatchInner& out);
  // Bilinear samples of the image at `place`, less the template's mean, and their sums. The caller has made sure that
  // all lie inside, 3 px from the right and the lower border.
  void (*patch_sums)(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, const PatchPlace& place,
                     const PatchInner& inner, PatchSums& out);
  // The same without the sums over gy, which a search along the row does without.
  void (*patch_sums_across)(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride,
                            const PatchPlace& place, const PatchInner& inner, PatchSums& out);
  // Adds one reference frame's part of the normal equations, and writes each observation's squared sigmas.
  void (*motion_sums)(const MotionTerms& terms, const MotionState& state, MotionSums& out);
};

extern const Kernels kReferenceKernels;
// Each is compiled for its set. Nothing from the standard library is called in kernels: the linker keeps one copy of an
// inline function for the whole program, and it may be the one that a lesser machine cannot run.
#if defined(__x86_64__)
void use_sse4(Kernels& table);
void use_avx2(Kernels& table);
void use_avx512(Kernels& table);
#elif defined(__aarch64__)
void use_neon(Kernels& table);
#endif

// One table per instruction set of this build and machine.
const KernelTables<Kernels>& kernel_tables();
// The one in force (core/base/isa.h).
const Kernels& kernels();

}  // namespace cliquevo::vo
