// SPDX-License-Identifier: BSD-3-Clause
// The row kernels in vectors of words, over the operations `V` of each instruction set; included like match_row.h.
// Where a kernel only writes, its last vector is put against the end of the row and does a part of it twice; where it
// adds, and in rows shorter than a vector, the plain kernel does the rest.

template <typename V>
struct RowKernels {
  using Reg = typename V::Reg;
  static constexpr int kWords = V::kBytes / 2;

  // Calls body(x) so that vectors at x cover [begin, end).
  template <typename Body>
  CLIQUEVO_INLINE static void cover(int begin, int end, const Body& body) {
    for (int x = begin; x < end; x += kWords) body(x + kWords <= end ? x : end - kWords);
  }

  struct CurveRegs {
    Reg knee[3], slope[3], range, half;
    explicit CurveRegs(const Curve& c) : range(V::broadcast16(c.range)), half(V::broadcast16(2048)) {
      for (int i = 0; i < 3; ++i) {
        knee[i] = V::broadcast16(c.knee[i]);
        slope[i] = V::broadcast16(c.slope[i]);
      }
    }
    CLIQUEVO_INLINE Reg operator()(Reg gradient) const {
      const Reg size = V::abs16(gradient);
      Reg sum = half;
      for (int i = 0; i < 3; ++i) sum = V::add16(sum, V::mul16(V::min16_signed(size, knee[i]), slope[i]));
      const Reg value = V::min16_signed(V::shift_right(sum, 12), range);
      return V::add16(range, V::signed_like(value, gradient));
    }
  };

  struct Gradients {
    Reg horizontal, vertical;
  };
  CLIQUEVO_INLINE static Gradients gradients(const PrefilterRow& in, int x) {
    const auto at = [](const std::uint8_t* row, int i) { return V::load_bytes(row + i); };
    const Reg a = at(in.above, x - 1);
    const Reg c = at(in.above, x + 1);
    const Reg g = at(in.below, x - 1);
    const Reg i = at(in.below, x + 1);
    const Reg along = V::sub16(at(in.row, x + 1), at(in.row, x - 1));
    const Reg across = V::sub16(at(in.below, x), at(in.above, x));
    const Reg rising = V::sub16(i, a);
    const Reg falling = V::sub16(g, c);
    return {V::add16(V::add16(along, along), V::sub16(rising, falling)),
            V::add16(V::add16(across, across), V::add16(rising, falling))};
  }

  static void prefilter_left(const PrefilterRow& given, Channels channels, int y, int cap, std::uint8_t* filtered,
                             std::uint8_t* matching) {
    const PrefilterRow in = given;
    const int last = in.width - 1;
    if (last - 1 < kWords) return reference::prefilter_left(given, channels, y, cap, filtered, matching);
    const CurveRegs curve(in.curve);
    const Reg high = V::broadcast16(cap);
    const Reg low = V::broadcast16(-cap);
    static constexpr Alternating kAlternating;
    filtered[0] = filtered[last] = static_cast<std::uint8_t>(cap);
    matching[0] = matching[last] = static_cast<std::uint8_t>(in.curve.range);
    cover(1, last, [&](int x) {
      const Gradients g = gradients(in, x);
      V::store_bytes(filtered + x, V::add16(high, V::max16_signed(low, V::min16_signed(high, g.horizontal))));
      const Reg chosen = channels == Channels::checkered
                             ? V::select(V::load(kAlternating.words + ((x + y) & 1)), g.vertical, g.horizontal)
                             : g.horizontal;
      V::store_bytes(matching + x, curve(chosen));
    });
  }

  static void prefilter_right(const PrefilterRow& given, std::uint8_t* horizontal, std::uint8_t* vertical) {
    const PrefilterRow in = given;
    const int last = in.width - 1;
    if (last - 1 < kWords) return reference::prefilter_right(given, horizontal, vertical);
    const CurveRegs curve(in.curve);
    horizontal[0] = horizontal[last] = vertical[0] = vertical[last] = static_cast<std::uint8_t>(in.curve.range);
    cover(1, last, [&](int x) {
      const Gradients g = gradients(in, x);
      V::store_bytes(horizontal + x, curve(g.horizontal));
      V::store_bytes(vertical + x, curve(g.vertical));
    });
  }

  static void texture_columns(const std::uint8_t* added, const std::uint8_t* removed, int neutral, int width,
                              std::uint16_t* columns) {
    const Reg middle = V::broadcast16(neutral);
    int x = 0;
    for (; x + kWords <= width; x += kWords) {
      const Reg in = V::abs16(V::sub16(V::load_bytes(added + x), middle));
      const Reg out = V::abs16(V::sub16(V::load_bytes(removed + x), middle));
      V::store(columns + x, V::add16(V::load(columns + x), V::sub16(in, out)));
    }
    reference::texture_columns(added + x, removed + x, neutral, width - x, columns + x);
  }

  static void texture_sums(const std::uint16_t* columns, int width, int radius, std::uint16_t* out) {
    if (width - 2 * radius < kWords) return reference::texture_sums(columns, width, radius, out);
    cover(radius, width - radius, [&](int x) {
      Reg sum = V::load(columns + x);
      for (int k = 1; k <= radius; ++k) {
        sum = V::add16(sum, V::add16(V::load(columns + x - k), V::load(columns + x + k)));
      }
      V::store(out + x, sum);
    });
  }

  // Each pixel's match is found in vectors, what the matches like best one by one, but without a branch.
  static void cross_check(const CrossCheck& given) {
    if (given.width < kWords) return reference::cross_check(given);
    static constexpr Rising kRising;
    const int width = given.width;
    const std::int16_t* const disparity = given.found.disparity();
    const std::uint16_t* const best = given.found.best();
    std::uint32_t* const partner = given.partner;
    std::int16_t* const match = given.astray;
    const Reg unknown = V::broadcast16(kUnknownDisparity);
    const Reg nowhere = V::broadcast16(-width);  // each of those has a place of its own behind the row
    const Reg rising = V::load(kRising.words);
    cover(0, width, [&](int x) {
      const Reg d = V::load(disparity + x);
      const Reg moved = V::select(V::equal16(d, unknown), nowhere, d);
      V::store(match + x, V::sub16(V::add16(rising, V::broadcast16(x)), moved));
    });
    const Reg nobody = V::broadcast16(-1);
    cover(0, 2 * width, [&](int i) { V::store(reinterpret_cast<std::uint16_t*>(partner) + i, nobody); });
    std::uint32_t* const offer = given.partner + 2 * width;
    for (int x = 0; x < width; ++x) {
      offer[x] = static_cast<std::uint32_t>(best[x]) << 16 | static_cast<std::uint32_t>(0xFFFF - x);
    }
#pragma GCC unroll 8
    for (int x = 0; x < width; ++x) {
      const std::size_t to = static_cast<std::uint16_t>(match[x]);
      const std::uint32_t other = partner[to];
      partner[to] = offer[x] < other ? offer[x] : other;
    }
#pragma GCC unroll 8
    for (int x = 0; x < width; ++x) {
      std::uint32_t taken = partner[static_cast<std::uint16_t>(match[x])];
      // Left to itself the compiler puts vectors together pixel by pixel, which takes twice as long.
      __asm__("" : "+r"(taken));
      match[x] = static_cast<std::int16_t>(taken);
    }
    for (int x = 0; x < width; ++x) match[x] = static_cast<std::int16_t>(~match[x] - x);
  }

  static void finish_row(const FinishRow& given, std::int16_t* out) {
    const FinishRow in = given;
    if (in.width < kWords) return reference::finish_row(given, out);
    const Reg unknown = V::broadcast16(kUnknownDisparity);
    const Reg one = V::broadcast16(1);
    const Reg scale = V::broadcast16(kDisparityScale);
    const typename V::Weights weights(100, 100 + in.uniqueness_percent);
    const Reg enough = V::broadcast16(in.texture_threshold);
    const Reg tolerance = V::broadcast16(in.left_right_tolerance);
    cover(0, in.width, [&](int x) {
      const Reg d = V::load(in.found.disparity() + x);
      const Reg best = V::load(in.found.best() + x);
      const Reg below = V::load(in.found.below() + x);
      const Reg above = V::load(in.found.above() + x);
      Reg bad = V::equal16(d, unknown);
      if (in.texture_threshold > 0) bad = V::either(bad, V::more16(enough, V::load(in.texture + x)));
      if (in.left_right_tolerance >= 0) {
        bad = V::either(bad, V::more16(V::abs16(V::load(in.astray + x)), tolerance));
      }
      if (in.uniqueness_percent > 0) {
        const Reg unique = V::more_weighted(V::load(in.found.second() + x), best, weights);
        bad = V::either(bad, V::equal16(unique, V::zero()));
      }
      const Reg slope = V::max16_signed(one, V::sub16(V::max16_signed(below, above), best));
      const Reg shift = V::eight_times_quotient(V::sub16(below, above), slope);
      V::store(out + x, V::select(bad, unknown, V::add16(V::mul16(d, scale), shift)));
    });
  }

  // All ones where |a - b| <= range; the step between an unknown value and a known one wraps to something far.
  CLIQUEVO_INLINE static Reg near(Reg a, Reg b, Reg range) {
    const Reg step = V::abs16(V::sub16(a, b));
    return V::equal16(V::min16(step, range), step);
  }

  static void link_row(const LinkRow& given) {
    const LinkRow in = given;
    const Reg unknown = V::broadcast16(kUnknownDisparity);
    const Reg range = V::broadcast16(in.range);
    std::int16_t first[kWords] = {kUnknownDisparity};  // nothing is read in front of the row
    for (int i = 1; i < kWords && i <= in.width; ++i) first[i] = in.row[i - 1];
    const auto words = [&](int x, Reg& known, Reg& across, Reg& down) {
      const Reg v = V::load(in.row + x);
      known = V::more16(v, unknown);
      across = V::both(known, near(v, V::load(x == 0 ? first : in.row + x - 1), range));
      down = V::both(known, near(v, V::load(in.above + x), range));
    };
    int word = 0;
    for (; word * 64 + 64 <= in.width; ++word) {
      std::uint64_t known = 0;
      std::uint64_t across = 0;
      std::uint64_t down = 0;
      for (int i = 0; i < 64; i += 2 * kWords) {
        Reg k[2], a[2], d[2];
        words(word * 64 + i, k[0], a[0], d[0]);
        words(word * 64 + i + kWords, k[1], a[1], d[1]);
        known |= V::bits(k[0], k[1]) << i;
        across |= V::bits(a[0], a[1]) << i;
        down |= V::bits(d[0], d[1]) << i;
      }
      in.known[word] = known;
      in.across[word] = across;
      in.down[word] = down;
    }
    const int done = word * 64;
    if (done == in.width) return;
    reference::link_row(
        {in.row + done, in.above + done, in.width - done, in.range, in.known + word, in.across + word, in.down + word});
    // The plain kernel takes its first pixel for the row's.
    if (done == 0 || in.row[done] == kUnknownDisparity || in.row[done - 1] == kUnknownDisparity) return;
    const int step = in.row[done] - in.row[done - 1];
    if (step <= in.range && step >= -in.range) in.across[word] |= 1;
  }

  static void smooth_row(const SmoothRow& given, int width, std::int16_t* out) {
    const SmoothRow in = given;
    if (width < kWords) return reference::smooth_row(given, width, out);
    const Reg unknown = V::broadcast16(kUnknownDisparity);
    const Reg reach = V::broadcast16(in.reach);
    const Reg scale = V::broadcast16(in.scale);
    const Reg round = V::broadcast16(in.round);
    static constexpr std::int16_t kShares[8] = {kReciprocals[0], kReciprocals[1], kReciprocals[2], kReciprocals[3],
                                                kReciprocals[4], kReciprocals[5], kReciprocals[6], kReciprocals[7]};
    const Reg shares = V::table_of_eight(kShares);
    cover(0, width, [&](int x) {
      const Reg z = V::load(in.centre + x);
      Reg sum = V::zero();
      Reg count = V::broadcast16(1);
      for (int i = 0; i < in.neighbours; ++i) {
        const Reg other = V::load(in.neighbour[i] + x);
        const Reg mask = near(other, z, reach);
        sum = V::add16(sum, V::both(mask, V::sub16(other, z)));
        count = V::sub16(count, mask);
      }
      const Reg mean = V::mul16_high(V::mul16(sum, scale), V::lookup(shares, count));
      const Reg value = V::add16(V::add16(V::mul16(z, scale), mean), round);
      V::store(out + x, V::select(V::equal16(z, unknown), unknown, V::shift_right_signed(value, in.shift)));
    });
  }

  struct Rising {
    std::int16_t words[kWords];
    constexpr Rising() : words() {
      for (int i = 0; i < kWords; ++i) words[i] = static_cast<std::int16_t>(i);
    }
  };
  struct Alternating {
    std::int16_t words[kWords + 1];
    constexpr Alternating() : words() {
      for (int i = 0; i < kWords + 1; ++i) words[i] = i % 2 == 0 ? 0 : -1;
    }
  };
};

inline constexpr std::uint8_t kWholeWeight[8] = {64, 64, 64, 64, 64, 64, 64, 64};

// Blocks of pixels whose sources lie close together take them out of three registers.
template <typename V>
void remap_row(const std::uint8_t* raw, std::ptrdiff_t stride, const RemapRow& given, int width, std::uint8_t* out) {
  using Reg = typename V::Reg;
  const RemapRow map = given;
  const Reg whole = V::load_half(kWholeWeight);
  const Reg column = V::broadcast16(0x7F7F);
  const Reg next = V::broadcast16(0x0100);
  const Reg half = V::broadcast16(32);
  int x = 0;
  for (; x + RemapRow::kBlock <= width; x += RemapRow::kBlock) {
    const RemapRow::Patch patch = map.patches[x / RemapRow::kBlock];
    if (patch.x < 0) {
      reference::remap_row(raw, stride, given, x, x + RemapRow::kBlock, out);
      continue;
    }
    const std::uint8_t* corner = raw + patch.y * stride + patch.x;
    const Reg place = V::load_half(map.at + x);
    const Reg places = V::interleave(place, place);
    const Reg lower = V::shift_right_signed(places, 15);
    const Reg from = V::add16(V::both(places, column), next);
    const Reg a = V::shuffle(V::load(corner), from);
    const Reg b = V::shuffle(V::load(corner + stride), from);
    const Reg c = V::shuffle(V::load(corner + 2 * stride), from);
    const Reg weight = V::load_half(map.weight_x + x);
    const Reg weights = V::interleave(V::sub8(whole, weight), weight);
    const Reg top = V::weighted_pairs(V::select(lower, b, a), weights);
    const Reg bottom = V::weighted_pairs(V::select(lower, c, b), weights);
    const Reg rise = V::sub16(bottom, top);
    // Twice the rise times 256 * weight, rounded and over 2^15: the reference's division by 64.
    const Reg share = V::mul16_high(V::add16(rise, rise), V::interleave(V::zero(), V::load_half(map.weight_y + x)));
    V::store_bytes(out + x, V::shift_right(V::add16(V::add16(top, share), half), 6));
  }
  reference::remap_row(raw, stride, given, x, width, out);
}

template <typename V, typename Narrow>
void use_rows(Table& table) {
  using Rows = RowKernels<V>;
  table.remap_row = remap_row<Narrow>;
  table.prefilter_left = Rows::prefilter_left;
  table.prefilter_right = Rows::prefilter_right;
  table.texture_columns = Rows::texture_columns;
  table.texture_sums = Rows::texture_sums;
  table.cross_check = Rows::cross_check;
  table.finish_row = Rows::finish_row;
  table.link_row = Rows::link_row;
  table.smooth_row = Rows::smooth_row;
}
