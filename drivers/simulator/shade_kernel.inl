// SPDX-License-Identifier: BSD-3-Clause
// Included by shade_reference.cpp and shade_avx2.cpp. Plain loops over blocks, for the compiler to vectorise; no libm,
// no reduction, so that every instruction set computes the same bits.
#include <cstdint>
#include <cstring>
#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "drivers/simulator/shade.h"
#include "drivers/simulator/texture.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr int kN = kShadeBlock;

inline std::int32_t as_int(float v) {
  std::int32_t i;
  std::memcpy(&i, &v, sizeof i);
  return i;
}

inline float as_float(std::int32_t i) {
  float v;
  std::memcpy(&v, &i, sizeof v);
  return v;
}

// Not the standard ones: an instance compiled for AVX2 could be the one that the linker keeps for everybody.
inline float least_of(float a, float b) { return b < a ? b : a; }
inline float most_of(float a, float b) { return a < b ? b : a; }

inline float absolute(float v) { return as_float(as_int(v) & 0x7fffffff); }

inline float root(float v) { return __builtin_sqrtf(v); }

inline std::int32_t floor_int(float v) {
  const auto i = static_cast<std::int32_t>(v);
  return i - (v < static_cast<float>(i) ? 1 : 0);
}

inline float bilinear(std::uint32_t q, float fu, float fv) {
  const auto a = static_cast<float>(static_cast<std::int32_t>(q & 255U));
  const auto b = static_cast<float>(static_cast<std::int32_t>((q >> 8) & 255U));
  const auto c = static_cast<float>(static_cast<std::int32_t>((q >> 16) & 255U));
  const auto d = static_cast<float>(static_cast<std::int32_t>(q >> 24));
  const float top = a + fu * (b - a);
  const float bottom = c + fu * (d - c);
  return top + fv * (bottom - top);
}

void load(const std::uint32_t* quads, const std::int32_t* index, std::uint32_t* out) {
#ifdef __AVX2__
  for (int i = 0; i < kN; i += 8) {
    const __m256i at = _mm256_load_si256(reinterpret_cast<const __m256i*>(index + i));
    const __m256i q = _mm256_i32gather_epi32(reinterpret_cast<const int*>(quads), at, 4);
    _mm256_store_si256(reinterpret_cast<__m256i*>(out + i), q);
  }
#else
  for (int i = 0; i < kN; ++i) out[i] = quads[index[i]];
#endif
}

// Texels index and index + 1, each with the one below it: bytes left, below left, right, below right.
void load_pairs(const std::uint16_t* pairs, const std::int32_t* index, std::uint32_t* out) {
#ifdef __AVX2__
  for (int i = 0; i < kN; i += 8) {
    const __m256i at = _mm256_load_si256(reinterpret_cast<const __m256i*>(index + i));
    const __m256i q = _mm256_i32gather_epi32(reinterpret_cast<const int*>(pairs), at, 2);
    _mm256_store_si256(reinterpret_cast<__m256i*>(out + i), q);
  }
#else
  for (int i = 0; i < kN; ++i) {
    const std::uint16_t* p = pairs + index[i];
    out[i] = p[0] | static_cast<std::uint32_t>(p[1]) << 16;
  }
#endif
}

struct Block {
  alignas(64) float x[kN], y[kN];            // ground point relative to the camera, m
  alignas(64) float axis_x[kN], axis_y[kN];  // unit vector along the footprint's long axis
  alignas(64) float offset[kN];              // of the two samples along it, m
  alignas(64) float size[kN];                // m: what one sample averages over
};

// Adds (texture - 128) along the block: trilinear, mean of one or two samples along the footprint's long axis.
void add_layer(const GroundLayer& layer, const Block& block, int taps, float* __restrict sum) {
  alignas(64) std::int32_t level[kN];
  alignas(64) float between[kN];
  for (int i = 0; i < kN; ++i) {
    // The exponent is the level, the mantissa the weight of the next: linear within an octave, continuous.
    const float texels = least_of(most_of(block.size[i] * layer.texels_per_m, 1.0F), 511.0F);
    const std::int32_t bits = as_int(texels);
    level[i] = (bits >> 23) - 127;
    between[i] = as_float((bits & 0x7fffff) | 0x3f800000) - 1.0F;
  }
  const float share = 1.0F / static_cast<float>(taps);
  for (int tap = 0; tap < taps; ++tap) {
    const float sign = taps == 1 ? 0.0F : (tap == 0 ? -1.0F : 1.0F);
    alignas(64) float u[kN], v[kN];
    for (int i = 0; i < kN; ++i) {
      const float offset = sign * block.offset[i];
      const float x = block.x[i] + offset * block.axis_x[i];
      const float y = block.y[i] + offset * block.axis_y[i];
      u[i] = layer.axis_u[0] * x + layer.axis_u[1] * y + layer.origin_u;
      v[i] = layer.axis_v[0] * x + layer.axis_v[1] * y + layer.origin_v;
    }
    for (int next = 0; next < 2; ++next) {
      alignas(64) std::int32_t index[kN];
      alignas(64) std::uint32_t quad[kN];
      alignas(64) float fu[kN], fv[kN];
      for (int i = 0; i < kN; ++i) {
        const std::int32_t l = level[i] + next;
        const float scale = as_float((127 - l) << 23);
        const float lu = u[i] * scale - 0.5F;
        const float lv = v[i] * scale - 0.5F;
        const std::int32_t iu = floor_int(lu);
        const std::int32_t iv = floor_int(lv);
        fu[i] = lu - static_cast<float>(iu);
        fv[i] = lv - static_cast<float>(iv);
        const std::int32_t bits = Tile::kLog2Size - l;
        const std::int32_t mask = (1 << bits) - 1;
        index[i] = (2 << (2 * Tile::kLog2Size)) - (2 << (2 * bits)) + (iv & mask) * ((1 << bits) + Tile::kPadding) +
                   (iu & mask);
      }
      load_pairs(layer.pairs, index, quad);
      for (int i = 0; i < kN; ++i) {
        const float weight = share * (next == 0 ? 1.0F - between[i] : between[i]);
        sum[i] += weight * (bilinear(quad[i], fv[i], fu[i]) - 128.0F);
      }
    }
  }
}

void ground(const GroundShading& s, const float* invz, const float* above, const float* below, int row, int begin,
            float* out) {
  Block block;
  alignas(64) float depth[kN];
  const auto j = static_cast<float>(row);
  const float row_x = s.start[0] + j * s.per_row[0];
  const float row_y = s.start[1] + j * s.per_row[1];
  for (int i = 0; i < kN; ++i) {
    const float w = most_of(invz[begin + i], 1e-3F);
    const float z = 1.0F / w;
    const auto column = static_cast<float>(begin + i);
    const float rx = row_x + column * s.per_column[0];
    const float ry = row_y + column * s.per_column[1];
    depth[i] = z;
    block.x[i] = z * rx;
    block.y[i] = z * ry;
    // Slope of 1/depth: of the two sides the smaller, which does not look across an edge.
    const float dv0 = w - above[begin + i];
    const float dv1 = below[begin + i] - w;
    const float dv = absolute(dv0) < absolute(dv1) ? dv0 : dv1;
    const float du0 = w - invz[begin + i - 1];
    const float du1 = invz[begin + i + 1] - w;
    const float du = absolute(du0) < absolute(du1) ? du0 : du1;
    // The pixel's footprint on the ground: its two edge vectors.
    const float zz = z * z;
    const float vx = z * s.per_row[0] - rx * zz * dv;
    const float vy = z * s.per_row[1] - ry * zz * dv;
    const float ux = z * s.per_column[0] - rx * zz * du;
    const float uy = z * s.per_column[1] - ry * zz * du;
    const float v_length = root(vx * vx + vy * vy);
    const float u_length = root(ux * ux + uy * uy);
    const bool v_longer = v_length > u_length;
    const float longer = v_longer ? v_length : u_length;
    const float shorter = v_longer ? u_length : v_length;
    // Two samples side by side along the long axis, overlapping those of the other passes (see renderer.cpp): their
    // spread is that of 0.8 pixels, so that together with the passes' offsets nothing finer than the pixels gets
    // through. Where the footprint is round one sample has that spread already.
    const float size = most_of(0.8F * shorter, 0.2F * longer);
    const float spread = 0.047F * longer * longer - (1.0F / 6.0F) * size * size;
    block.size[i] = size;
    block.offset[i] = root(most_of(spread, 0.0F));
    const float inverse = 1.0F / most_of(longer, 1e-9F);
    block.axis_x[i] = inverse * (v_longer ? vx : ux);
    block.axis_y[i] = inverse * (v_longer ? vy : uy);
  }
  int round = 0;
  for (int i = 0; i < kN; ++i) round += block.offset[i] <= 0.0F ? 1 : 0;
  const int taps = round == kN ? 1 : 2;

  alignas(64) float gravel[kN] = {};
  alignas(64) float grass[kN] = {};
  add_layer(s.gravel, block, taps, gravel);
  add_layer(s.grass, block, taps, grass);

  alignas(64) std::int32_t index[kN];
  alignas(64) std::uint32_t brightness[kN], grassiness[kN];
  alignas(64) float fu[kN], fv[kN];
  for (int i = 0; i < kN; ++i) {
    const float u =
        least_of(most_of(block.x[i] * s.grid_per_m + s.grid_x, 0.0F), static_cast<float>(s.grid_columns - 2));
    const float v = least_of(most_of(block.y[i] * s.grid_per_m + s.grid_y, 0.0F), static_cast<float>(s.grid_rows - 2));
    const auto iu = static_cast<std::int32_t>(u);
    const auto iv = static_cast<std::int32_t>(v);
    fu[i] = u - static_cast<float>(iu);
    fv[i] = v - static_cast<float>(iv);
    index[i] = iv * s.grid_columns + iu;
  }
  load(s.brightness, index, brightness);
  load(s.grassiness, index, grassiness);
  for (int i = 0; i < kN; ++i) {
    const float base = bilinear(brightness[i], fu[i], fv[i]);
    const float mix = bilinear(grassiness[i], fu[i], fv[i]) * (1.0F / 255.0F);
    const float detail = (mix * grass[i] + (1.0F - mix) * gravel[i]) * (0.95F / 128.0F);
    const float lit = base * most_of(1.0F + detail, 0.08F);
    const float haze = least_of(most_of((depth[i] - s.haze_begin_m) * s.haze_per_m, 0.0F), 1.0F);
    const float soft = haze * haze * (3.0F - 2.0F * haze);
    out[i] = lit + soft * (s.haze_grey - lit);
  }
}

void sky(const SkyShading& s, int row, int begin, float* out) {
  alignas(64) std::int32_t index[kN];
  alignas(64) std::uint32_t quad[kN];
  alignas(64) float fu[kN], fv[kN];
  const auto j = static_cast<float>(row);
  for (int i = 0; i < kN; ++i) {
    const auto column = static_cast<float>(begin + i);
    const float x = s.start[0] + j * s.per_row[0] + column * s.per_column[0];
    const float y = s.start[1] + j * s.per_row[1] + column * s.per_column[1];
    const float z = s.start[2] + j * s.per_row[2] + column * s.per_column[2];
    // Azimuth in turns: atan by a polynomial on the octant (error below 2e-6 turns).
    const float ax = absolute(x);
    const float ay = absolute(y);
    const float t = least_of(ax, ay) / most_of(most_of(ax, ay), 1e-9F);
    const float t2 = t * t;
    float angle =
        t * (0.15915133F +
             t2 * (-0.05293770F + t2 * (0.03080335F + t2 * (-0.01853087F + t2 * (0.00838004F - t2 * 0.00186549F)))));
    angle = ay > ax ? 0.25F - angle : angle;
    angle = x < 0.0F ? 0.5F - angle : angle;
    angle = y < 0.0F ? 1.0F - angle : angle;
    const float rise = z / most_of(root(x * x + y * y), 1e-9F);
    const float u = angle * static_cast<float>(Panorama::kWidth);
    const float v = least_of(
        most_of((rise - Panorama::kLowestRise) * (static_cast<float>(Panorama::kHeight) / Panorama::kRiseSpan), 0.0F),
        static_cast<float>(Panorama::kHeight - 2));
    const auto iu = static_cast<std::int32_t>(u);
    const auto iv = static_cast<std::int32_t>(v);
    fu[i] = u - static_cast<float>(iu);
    fv[i] = v - static_cast<float>(iv);
    index[i] = (iv << Panorama::kLog2Width) + (iu & (Panorama::kWidth - 1));
  }
  load(s.quads, index, quad);
  for (int i = 0; i < kN; ++i) out[i] = bilinear(quad[i], fu[i], fv[i]);
}

}  // namespace

}  // namespace cliquevo::drivers::sim
