// SPDX-License-Identifier: BSD-3-Clause
// The vector matcher, written once over a small set of operations `V` that each instruction set supplies (see
// x86_match.h). Included inside an anonymous namespace by each of them, so that no code compiled for one machine is
// linked into another's path; for the same reason nothing from the standard library is called here.
//
// Vectors run over disparities: element e of a pixel is disparity last - e, so that the right image is read upwards.
// Column sums are bytes in the order of e. Costs are kept as keys, cost * weight + place, in 16 bits: of each vector of
// bytes the even elements form one register of keys and the odd ones another. `place` is 2 * (e / 16) + (e & 1), the
// lane within eight gives the rest, so that the smallest key of a pixel carries cost and disparity at once.

#define CLIQUEVO_INLINE [[gnu::always_inline]] inline

// All ones in two lanes, to be slid over the pairs.
struct TwoOut {
  static constexpr int kCentre = 128;
  std::uint16_t lanes[2 * kCentre + 32];
  constexpr TwoOut() : lanes() { lanes[kCentre] = lanes[kCentre + 1] = 0xFFFF; }
  static constexpr std::uint16_t slid(int pair) { return static_cast<std::uint16_t>(2 * (kCentre - pair)); }  // bytes
};

// What belongs to the winner of a pixel, by its lane and place. Its neighbours and itself fill two pairs of elements
// but for one element, the one beyond: the second look takes both pairs out whole and looks at that one alone.
// kCovers: it takes them out in memory, not in registers.
template <int kBytes, int kPadded, bool kCovers>
struct Winners {
  static constexpr int kWeight = key_weight(kPadded);
  struct Entry {
    std::uint16_t nearer, farther, beyond;  // where their keys lie, bytes
    std::uint16_t pairs;                    // where their smaller keys lie, or TwoOut's lanes for them start, bytes
  };
  Entry at[kWeight * 8];

  static constexpr std::uint16_t offset(int e) {
    if (e < 0 || e >= kPadded) return 0;  // ends of the range are thrown away later
    return static_cast<std::uint16_t>(2 * (e / kBytes * kBytes + (e & 1) * (kBytes / 2) + e % kBytes / 2));
  }
  static constexpr std::uint16_t pairs(int e) {
    const int pair = (e & 1) != 0 || e == 0 ? e / 2 : e / 2 - 1;
    if (!kCovers) return TwoOut::slid(pair);
    return static_cast<std::uint16_t>(2 * (kPadded + (pair < kPadded / 2 - 2 ? pair : kPadded / 2 - 2)));
  }
  constexpr Winners() : at() {
    for (int place = 0; place < kWeight; ++place) {
      for (int lane = 0; lane < 8; ++lane) {
        const int e = (place >> 1) * 16 + 2 * lane + (place & 1);
        const bool is_odd = (e & 1) != 0;
        at[lane * kWeight + place] = {offset(e - 1), offset(e + 1), offset(is_odd ? e + 2 : e - 2), pairs(e)};
      }
    }
  }
};

// Lanes that are all ones at both ends, to be slid over the keys of one parity until those are covered that lie outside
// the image.
struct Outside {
  static constexpr int kMost = 128 + kMatchBlock;
  std::uint16_t lanes[5 * kMost];
  constexpr Outside() : lanes() {
    for (int i = 0; i < kMost; ++i) lanes[i] = lanes[3 * kMost + i] = lanes[4 * kMost + i] = 0xFFFF;
  }
  const std::uint16_t* first(int n) const { return lanes + kMost - n; }     // covers n keys; n <= kMost
  const std::uint16_t* from(int n) const { return lanes + 3 * kMost - n; }  // all but n keys; -kMost <= n <= kMost
};

// Where in a row windows reach beyond the images for some disparities: nowhere, beyond the left edge of the right one,
// anywhere.
enum class Edge { none, left, any };

template <typename V, int kVectors>
struct RowMatcher {
  using Reg = typename V::Reg;
  static constexpr int kBytes = V::kBytes;
  static constexpr int kKeys = kBytes / 2;  // keys in a register
  static constexpr int kPadded = kVectors * kBytes;
  static constexpr int kWeight = key_weight(kPadded);
  static constexpr int kBlock = kMatchBlock;
  static constexpr int kCells = kPadded + kPadded / 2;  // keys of a pixel, then the smaller of each pair
  // A cover must have reached the cache before the whole row of pairs is read again: it costs a block more of keys, for
  // which there is room as long as they are small.
  static constexpr bool kCovers = kPadded <= 64;
  using WinnerTable = Winners<kBytes, kPadded, kCovers>;

  const MatchJob job;
  const int radius = job.window / 2;
  const int last = job.min_disparity + job.num_disparities - 1;
  std::uint8_t* const columns = job.columns + kPadded;  // a column of zeros comes first
  std::uint16_t* const ring = job.costs;                // keys of three blocks of pixels
  std::uint32_t* const spread =
      reinterpret_cast<std::uint32_t*>(job.columns + static_cast<std::ptrdiff_t>(kPadded) * (job.width + kBlock + 1));

  // Kept beside the job: stores of costs might change it, for all that the compiler knows.
  std::uint32_t* const found = job.out.found();
  std::uint16_t* const nearer = job.out.above();
  std::uint16_t* const farther = job.out.below();
  std::uint16_t* const beyond = job.out.beyond();
  std::uint32_t* const other = job.out.other();

  explicit RowMatcher(const MatchJob& j) : job(j) {}

  using Pixel = typename V::Pixel;  // of the left image, as it is quickest to broadcast
  struct Row {
    const Pixel* left;
    const std::uint8_t* right[2];  // by parity of x, at element 0
  };
  Row row(int y, std::uint32_t* scratch) const {
    const int clamped = y < 0 ? 0 : (y >= job.height ? job.height - 1 : y);
    const std::ptrdiff_t offset = clamped * job.stride;
    return {V::spread(job.left + offset, job.width + kBlock, scratch),
            {job.right[channel(job.channels, 0, clamped)] + offset - last,
             job.right[channel(job.channels, 1, clamped)] + offset - last}};
  }

  // The sums of the row before, which run() then moves on like any other's.
  void build_columns() const {
    for (int i = -kPadded; i < (job.width + kBlock) * kPadded; i += kBytes) V::store(columns + i, V::zero());
    const int rows = job.window_height / 2;
    for (int j = -rows; j <= rows; ++j) {
      const Row in = row(job.y - job.step + j, spread);
      for (int x = 0; x < job.width + kBlock; ++x) {
        const Reg pixel = V::broadcast_pixel(in.left + x);
        const std::uint8_t* right = in.right[x & 1] + x;
        std::uint8_t* column = columns + static_cast<std::ptrdiff_t>(x) * kPadded;
        for (int e = 0; e < kPadded; e += kBytes) {
          V::store(column + e, V::add8(V::load(column + e), V::difference(pixel, V::load(right + e))));
        }
      }
    }
  }

  // The sums of the columns in the window, as keys.
  struct Sums {
    Reg even[kVectors];
    Reg odd[kVectors];
  };
  struct Factors {
    Reg even, odd;
  };

  // Moves one column on by a row and into the window, and another one out.
  CLIQUEVO_INLINE static void enter(Sums& sums, const Factors& factors, const Pixel* left_in, const Pixel* left_out,
                                    const std::uint8_t* right_in, const std::uint8_t* right_out, std::uint8_t* column,
                                    const std::uint8_t* leaving) {
    const Reg pixel_in = V::broadcast_pixel(left_in);
    const Reg pixel_out = V::broadcast_pixel(left_out);
#pragma GCC unroll 16
    for (int v = 0; v < kVectors; ++v) {
      const Reg added = V::difference(pixel_in, V::load(right_in + v * kBytes));
      const Reg removed = V::difference(pixel_out, V::load(right_out + v * kBytes));
      const Reg sum = V::add8(V::load(column + v * kBytes), V::sub8(added, removed));
      V::store(column + v * kBytes, sum);
      V::accumulate(sums.even[v], sums.odd[v], V::sub8(sum, V::load(leaving + v * kBytes)), factors.even, factors.odd);
    }
  }

  // Stores the keys of pixel x and finds the smallest one. Elements below `low` and above `high` lie outside.
  template <Edge kEdge>
  CLIQUEVO_INLINE void find_best(int x, int low, int high, Sums sums, std::uint16_t* key) const {
    static constexpr Outside kOutside;
    if constexpr (kEdge != Edge::none) {
      const std::uint16_t* const low_even = kOutside.first((low + 1) >> 1);
      const std::uint16_t* const low_odd = kOutside.first(low >> 1);
#pragma GCC unroll 16
      for (int v = 0; v < kVectors; ++v) {
        sums.even[v] = V::either(sums.even[v], V::load(low_even + v * kKeys));
        sums.odd[v] = V::either(sums.odd[v], V::load(low_odd + v * kKeys));
      }
    }
    if constexpr (kEdge == Edge::any) {
      const int final = high < job.num_disparities ? high : job.num_disparities - 1;
      const std::uint16_t* const high_even = kOutside.from((final + 2) >> 1);
      const std::uint16_t* const high_odd = kOutside.from((final + 1) >> 1);
#pragma GCC unroll 16
      for (int v = 0; v < kVectors; ++v) {
        sums.even[v] = V::either(sums.even[v], V::load(high_even + v * kKeys));
        sums.odd[v] = V::either(sums.odd[v], V::load(high_odd + v * kKeys));
      }
    }
    Reg least{};
#pragma GCC unroll 16
    for (int v = 0; v < kVectors; ++v) {
      V::store(key + v * kBytes, sums.even[v]);
      V::store(key + v * kBytes + kKeys, sums.odd[v]);
      const Reg pairs = V::min16(sums.even[v], sums.odd[v]);
      V::store(key + kPadded + v * kKeys, pairs);
      least = v == 0 ? pairs : V::min16(least, pairs);
    }
    found[x] = V::minimum(least);  // key, lane << 16
  }

  // A block later, when the winners' places no longer have to be waited for: their neighbours, and the second look, or
  // the covers for it.
  template <bool kSecond>
  CLIQUEVO_INLINE void settle(int x, std::uint16_t* keys) const {
    static constexpr WinnerTable kWinners;
    [[maybe_unused]] static constexpr TwoOut kTwoOut;
    const std::uint32_t* const won = found + x;
    unsigned place[kBlock];
    for (int i = 0; i < kBlock; ++i) place[i] = (won[i] >> 16) * kWeight + (won[i] & (kWeight - 1));
    char* key = reinterpret_cast<char*>(keys);
    std::uint16_t* const near = nearer + x;
    std::uint16_t* const far = farther + x;
    std::uint16_t* const next = beyond + x;
    [[maybe_unused]] std::uint32_t* const least_other = other + x;
#pragma GCC unroll 2
    for (int i = 0; i < kBlock; ++i, key += sizeof(std::uint16_t) * kCells) {
      const auto& winner = kWinners.at[place[i]];
      const auto at = [key](std::uint16_t offset) { return *reinterpret_cast<const std::uint16_t*>(key + offset); };
      near[i] = at(winner.nearer);
      far[i] = at(winner.farther);
      if constexpr (kSecond) {
        next[i] = at(winner.beyond);
        if constexpr (kCovers) {
          __builtin_memset(key + winner.pairs, 0xFF, 2 * sizeof(std::uint16_t));
        } else {
          const char* const two = reinterpret_cast<const char*>(kTwoOut.lanes) + winner.pairs;
          Reg least{};
#pragma GCC unroll 16
          for (int v = 0; v < kVectors; ++v) {
            const Reg others = V::either(V::load(key + 2 * kPadded + v * kBytes), V::load(two + v * kBytes));
            least = v == 0 ? others : V::min16(least, others);
          }
          least_other[i] = V::minimum(least);
        }
      }
    }
  }

  // The second look, another block later, when the covers have reached the cache: the smallest of the other keys.
  CLIQUEVO_INLINE void look_again(int x, const std::uint16_t* key) const {
    std::uint32_t* const least_other = other + x;
#pragma GCC unroll 4
    for (int i = 0; i < kBlock; ++i, key += kCells) {
      Reg least = V::load(key + kPadded);
#pragma GCC unroll 16
      for (int v = 1; v < kVectors; ++v) least = V::min16(least, V::load(key + kPadded + v * kKeys));
      least_other[i] = V::minimum(least);
    }
  }

  template <Edge kEdge>
  CLIQUEVO_INLINE void match_block(int x, const Row& in, const Row& out, Sums& sums, const Factors& factors,
                                   std::uint16_t* keys) const {
    const Pixel* left_in = in.left + x + radius;
    const Pixel* left_out = out.left + x + radius;
    const std::uint8_t* right_in[2] = {in.right[0] + x + radius, in.right[1] + x + radius};
    const std::uint8_t* right_out[2] = {out.right[0] + x + radius, out.right[1] + x + radius};
    std::uint8_t* column = columns + static_cast<std::ptrdiff_t>(x + radius) * kPadded;
    const std::uint8_t* leaving = columns + static_cast<std::ptrdiff_t>(x - radius - 1) * kPadded;
    // Clamped for all of the block; what is below 0 covers nothing.
    int low = last + radius - x;
    low = low < 0 ? 0 : (low > 2 * Outside::kMost ? 2 * Outside::kMost : low);
    const int high = job.width - 1 - radius - x + job.num_disparities - 1 + job.min_disparity;
    for (int i = 0; i < kBlock; i += 2) {
      enter(sums, factors, left_in + i, left_out + i, right_in[0] + i, right_out[0] + i, column, leaving);
      find_best<kEdge>(x + i, low - i, high - i, sums, keys);
      enter(sums, factors, left_in + i + 1, left_out + i + 1, right_in[1] + i + 1, right_out[1] + i + 1,
            column + kPadded, leaving + kPadded);
      find_best<kEdge>(x + i + 1, low - i - 1, high - i - 1, sums, keys + kCells);
      column += 2 * kPadded;
      leaving += 2 * kPadded;
      keys += 2 * kCells;
    }
  }

  void run() const {
    if (job.first) build_columns();
    job.second ? match_row<true>() : match_row<false>();
  }

  template <bool kSecond>
  void match_row() const {
    const Row in = row(job.y + job.step * (job.window_height / 2), spread);
    const Row out = row(job.y - job.step * (job.window_height / 2 + 1), spread + spread_cells(job.width));
    const Factors factors{V::factor_even(kWeight), V::factor_odd(kWeight)};
    Sums sums;
    for (int v = 0; v < kVectors; ++v) {
      sums.even[v] = V::places(v * kBytes / 8);
      sums.odd[v] = V::places(v * kBytes / 8 + 1);
    }
    for (int x = 0; x < 2 * radius; ++x) {
      enter(sums, factors, in.left + x, out.left + x, in.right[x & 1] + x, out.right[x & 1] + x,
            columns + static_cast<std::ptrdiff_t>(x) * kPadded, columns - kPadded);
    }
    // Blocks of pixels, the last one reaching beyond the row. Where every disparity can be seen no masks are needed.
    const int begin = radius;
    const int end = job.width - radius;
    const bool full = job.num_disparities == kPadded;
    const int all_begin = last + radius;
    const int all_end = end + (job.min_disparity < 0 ? job.min_disparity : 0);
    std::uint16_t* keys = ring;
    std::uint16_t* earlier = ring + kBlock * kCells;
    std::uint16_t* earliest = ring + 2 * kBlock * kCells;
    constexpr bool kLater = kSecond && kCovers;
    for (int x = begin; x < end + (kLater ? 2 : 1) * kBlock; x += kBlock) {
      if (full && x >= all_begin && x + kBlock <= all_end) {
        match_block<Edge::none>(x, in, out, sums, factors, keys);
      } else if (full && x + kBlock <= all_end) {
        match_block<Edge::left>(x, in, out, sums, factors, keys);
      } else if (x < end) {
        match_block<Edge::any>(x, in, out, sums, factors, keys);
      }
      if (x > begin && x < end + kBlock) settle<kSecond>(x - kBlock, earlier);
      if constexpr (kLater) {
        if (x > begin + kBlock) look_again(x - 2 * kBlock, earliest);
      }
      std::uint16_t* const free = kLater ? earliest : earlier;
      earliest = earlier;
      earlier = keys;
      keys = free;
    }
    decode<kSecond>(begin, end);
  }

  // Keys to costs, winners to disparities.
  template <bool kSecond>
  void decode(int begin, int end) const {
    std::int16_t* const disparity = job.out.disparity();
    std::uint16_t* const best = job.out.best();
    std::uint16_t* const second = job.out.second();
    constexpr int kShift = __builtin_ctz(static_cast<unsigned>(kWeight));
    for (int x = 0; x < begin; ++x) disparity[x] = kUnknownDisparity;
    for (int x = end; x < job.width; ++x) disparity[x] = kUnknownDisparity;
    const int highest = last;
    const int lowest = job.min_disparity;
    const int left_limit = radius;
    const int right_limit = radius - job.width + 1;
#if defined(__clang__)
#pragma clang loop vectorize(assume_safety)
#else
#pragma GCC ivdep
#endif
    for (int x = begin; x < end; ++x) {
      const int key = static_cast<int>(found[x] & 0xFFFF);
      const int place = key & (kWeight - 1);
      const int lane = static_cast<int>(found[x] >> 16);
      const int d = highest - ((place >> 1) * 16 + 2 * lane + (place & 1));
      const int high = x - left_limit < highest ? x - left_limit : highest;
      const int low = x + right_limit > lowest ? x + right_limit : lowest;
      disparity[x] = static_cast<std::int16_t>(d > low && d < high ? d : kUnknownDisparity);
      best[x] = static_cast<std::uint16_t>(key >> kShift);
      farther[x] = static_cast<std::uint16_t>(farther[x] >> kShift);
      nearer[x] = static_cast<std::uint16_t>(nearer[x] >> kShift);
    }
    if constexpr (!kSecond) return;
#if defined(__clang__)
#pragma clang loop vectorize(assume_safety)
#else
#pragma GCC ivdep
#endif
    for (int x = begin; x < end; ++x) {
      const std::uint16_t others = static_cast<std::uint16_t>(other[x]);
      second[x] = static_cast<std::uint16_t>((others < beyond[x] ? others : beyond[x]) >> kShift);
    }
  }
};

template <typename V>
void match_row_with(const MatchJob& job) {
  constexpr int kVectorsIn32 = 32 / V::kBytes;
  switch (padded_disparities(job.num_disparities) / 32) {
    case 1:
      return RowMatcher<V, kVectorsIn32>(job).run();
    case 2:
      return RowMatcher<V, 2 * kVectorsIn32>(job).run();
    case 3:
      return RowMatcher<V, 3 * kVectorsIn32>(job).run();
    case 4:
      return RowMatcher<V, 4 * kVectorsIn32>(job).run();
    case 5:
      return RowMatcher<V, 5 * kVectorsIn32>(job).run();
    case 6:
      return RowMatcher<V, 6 * kVectorsIn32>(job).run();
    case 7:
      return RowMatcher<V, 7 * kVectorsIn32>(job).run();
    default:
      return RowMatcher<V, 8 * kVectorsIn32>(job).run();
  }
}
