// SPDX-License-Identifier: BSD-3-Clause
// The vector matcher, written once over a small set of operations `V` that each instruction set supplies (see
// avx2.cpp). Included inside an anonymous namespace by each of them, so that no code compiled for one machine is linked
// into another's path; for the same reason nothing from the standard library is called here.
//
// Vectors run over disparities: element e of a pixel is disparity last - e, so that the right image is read upwards.
// A key is cost * weight + (e >> 3) within its group: the minimum of the keys tells the cost and, with the lane it sits
// in, the disparity; of equal costs the smallest e, the nearest point, wins.

template <typename V>
struct RowMatcher {
  using Reg = typename V::Reg;
  static constexpr int kLanes = V::kBytes / 2;

  const MatchJob& job;
  const int padded = padded_disparities(job.num_disparities);
  const int radius = job.window / 2;
  const int last = job.min_disparity + job.num_disparities - 1;
  int group = 0;   // disparities whose keys are compared with each other
  int weight = 0;  // of a cost within a key
  int shift = 0;   // log2(weight)

  explicit RowMatcher(const MatchJob& j) : job(j) {
    const int highest = job.window * (job.window * (127 / job.window) * 2);
    weight = 1;
    while (highest * weight * 2 + weight * 2 < 65535 && weight * 8 < padded) weight *= 2, ++shift;
    group = weight * 8;
  }

  static int clamp_row(int y, int height) { return y < 0 ? 0 : (y >= height ? height - 1 : y); }
  const std::uint8_t* left_row(int y) const { return job.left + clamp_row(y, job.height) * job.stride; }
  const std::uint8_t* right_row(int y) const { return job.right + clamp_row(y, job.height) * job.stride - last; }

  void build_columns() const {
    for (int i = 0; i < job.width * padded; i += V::kBytes) V::store(job.columns + i, V::zero());
    for (int j = -radius; j <= radius; ++j) {
      const std::uint8_t* l = left_row(job.y + j);
      const std::uint8_t* r = right_row(job.y + j);
      for (int x = 0; x < job.width; ++x) {
        const Reg pixel = V::broadcast8(l[x]);
        std::uint8_t* column = job.columns + static_cast<std::ptrdiff_t>(x) * padded;
        for (int e = 0; e < padded; e += V::kBytes) {
          V::store(column + e, V::add8(V::load(column + e), V::difference(pixel, V::load(r + x + e))));
        }
      }
    }
  }

  void move_columns() const {
    const std::uint8_t* l_in = left_row(job.y + radius);
    const std::uint8_t* r_in = right_row(job.y + radius);
    const std::uint8_t* l_out = left_row(job.y - radius - 1);
    const std::uint8_t* r_out = right_row(job.y - radius - 1);
    for (int x = 0; x < job.width; ++x) {
      const Reg in = V::broadcast8(l_in[x]);
      const Reg out = V::broadcast8(l_out[x]);
      std::uint8_t* column = job.columns + static_cast<std::ptrdiff_t>(x) * padded;
      for (int e = 0; e < padded; e += V::kBytes) {
        const Reg change =
            V::sub8(V::difference(in, V::load(r_in + x + e)), V::difference(out, V::load(r_out + x + e)));
        V::store(column + e, V::add8(V::load(column + e), change));
      }
    }
  }

  // Where element e lies in the cost buffer: unpacking bytes to words shuffles the lanes of wide registers.
  static int address(int e) { return V::kBytes == 32 ? (e & ~31) | (e & 8) << 1 | (e & 16) >> 1 | (e & 7) : e; }

  void run() const {
    if (job.first) {
      build_columns();
    } else {
      move_columns();
    }
    std::uint16_t* sums = job.costs;             // running sums as keys, of the pixel at hand
    std::uint16_t* masked = job.costs + padded;  // the same, impossible ones at 65535
    for (int e = 0; e < padded; ++e) sums[address(e)] = static_cast<std::uint16_t>((e % group) >> 3);
    for (int x = 0; x < job.width; ++x) job.out.disparity[x] = kUnknownDisparity;
    alignas(64) static const std::uint8_t kNothing[288] = {};
    for (int x = -radius; x < job.width - radius; ++x) {
      const std::uint8_t* in = job.columns + static_cast<std::ptrdiff_t>(x + radius) * padded;
      const std::uint8_t* out =
          x > radius ? job.columns + static_cast<std::ptrdiff_t>(x - radius - 1) * padded : kNothing;
      const Reg factors = V::factors(weight);
      for (int e = 0; e < padded; e += V::kBytes) {
        Reg lo = V::load(sums + e);
        Reg hi = V::load(sums + e + kLanes);
        V::accumulate(lo, hi, V::load(in + e), V::load(out + e), factors);
        V::store(sums + e, lo);
        V::store(sums + e + kLanes, hi);
      }
      if (x >= radius) find_best(x, sums, masked);
    }
  }

  void find_best(int x, const std::uint16_t* sums, std::uint16_t* masked) const {
    // Both windows lie within their images for elements first..final.
    const int least = x + radius - job.width + 1;
    const int final = job.num_disparities - 1 - (least > job.min_disparity ? least - job.min_disparity : 0);
    const int first = x - radius < last ? last - (x - radius) : 0;
    if (final - first < 2) return;
    for (int i = 0; i < padded; i += kLanes) V::store(masked + i, V::load(sums + i));
    for (int e = 0; e < first; ++e) masked[address(e)] = 65535;
    for (int e = final + 1; e < padded; ++e) masked[address(e)] = 65535;
    int best = 65536;
    int best_e = 0;
    for (int g = 0; g < padded; g += group) {
      Reg m = V::load(masked + g);
      const int end = g + group < padded ? g + group : padded;
      for (int i = g + kLanes; i < end; i += kLanes) m = V::min16(m, V::load(masked + i));
      int lane = 0;
      const int key = V::minimum(m, lane);
      if ((key >> shift) < best) {
        best = key >> shift;
        best_e = g + (key & (weight - 1)) * 8 + lane;
      }
    }
    if (best_e <= first || best_e >= final) return;
    job.out.disparity[x] = static_cast<std::int16_t>(last - best_e);
    job.out.best[x] = static_cast<std::uint16_t>(best);
    job.out.below[x] = static_cast<std::uint16_t>(masked[address(best_e + 1)] >> shift);
    job.out.above[x] = static_cast<std::uint16_t>(masked[address(best_e - 1)] >> shift);
    for (int e = best_e - 1; e <= best_e + 1; ++e) masked[address(e)] = 65535;
    Reg m = V::load(masked);
    for (int i = kLanes; i < padded; i += kLanes) m = V::min16(m, V::load(masked + i));
    int lane = 0;
    const int key = V::minimum(m, lane);
    job.out.second[x] = static_cast<std::uint16_t>(key == 65535 ? key : key >> shift);
  }
};
