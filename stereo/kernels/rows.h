// SPDX-License-Identifier: BSD-3-Clause
// Row kernels in a form that the compiler turns into vectors by itself: 16-bit arithmetic, no branches, no aliasing.
// Included inside an anonymous namespace by each instruction set, like match_row.h.

inline std::uint8_t curved(std::int16_t gradient, const Curve& c) {
  const auto size = static_cast<std::uint16_t>(gradient < 0 ? -gradient : gradient);
  const auto a = static_cast<std::uint16_t>(size < c.knee[0] ? size : c.knee[0]);
  const auto b = static_cast<std::uint16_t>(size < c.knee[1] ? size : c.knee[1]);
  const auto d = static_cast<std::uint16_t>(size < c.knee[2] ? size : c.knee[2]);
  const auto sum = static_cast<std::uint16_t>(static_cast<std::uint16_t>(a * c.slope[0]) +
                                              static_cast<std::uint16_t>(b * c.slope[1]) +
                                              static_cast<std::uint16_t>(d * c.slope[2]) + 2048);
  const auto scaled = static_cast<std::int16_t>(sum >> 12);
  const auto range = static_cast<std::int16_t>(c.range);
  const std::int16_t value = scaled < range ? scaled : range;
  return static_cast<std::uint8_t>(gradient < 0 ? range - value : range + value);
}

inline std::int16_t across(const PrefilterRow& in, int x) {
  return static_cast<std::int16_t>(in.above[x + 1] - in.above[x - 1] + 2 * (in.row[x + 1] - in.row[x - 1]) +
                                   in.below[x + 1] - in.below[x - 1]);
}

inline std::int16_t down(const PrefilterRow& in, int x) {
  return static_cast<std::int16_t>(in.below[x - 1] - in.above[x - 1] + 2 * (in.below[x] - in.above[x]) +
                                   in.below[x + 1] - in.above[x + 1]);
}

void vector_prefilter_left(const PrefilterRow& given, Channels channels, int y, int cap,
                           std::uint8_t* __restrict filtered, std::uint8_t* __restrict matching) {
  const PrefilterRow in = given;
  const auto high = static_cast<std::int16_t>(cap);
  const auto low = static_cast<std::int16_t>(-cap);
  const int last = in.width - 1;
  filtered[0] = filtered[last] = static_cast<std::uint8_t>(cap);
  matching[0] = matching[last] = static_cast<std::uint8_t>(in.curve.range);
  const bool checkered = channels == Channels::checkered;
  const int parity = y & 1;
  for (int x = 1; x < last; ++x) {
    const std::int16_t v = across(in, x);
    const std::int16_t above_low = v < low ? low : v;
    const std::int16_t clipped = above_low > high ? high : above_low;
    filtered[x] = static_cast<std::uint8_t>(clipped + high);
    matching[x] = curved(checkered && ((x ^ parity) & 1) != 0 ? down(in, x) : v, in.curve);
  }
}

void vector_prefilter_right(const PrefilterRow& given, std::uint8_t* __restrict horizontal,
                            std::uint8_t* __restrict vertical) {
  const PrefilterRow in = given;
  const int last = in.width - 1;
  horizontal[0] = horizontal[last] = vertical[0] = vertical[last] = static_cast<std::uint8_t>(in.curve.range);
  for (int x = 1; x < last; ++x) {
    horizontal[x] = curved(across(in, x), in.curve);
    vertical[x] = curved(down(in, x), in.curve);
  }
}

void vector_smooth(const SmoothRow& given, int width, std::int16_t* __restrict out) {
  const SmoothRow in = given;
  const std::int16_t* const __restrict centre = in.centre;
  const auto reach = static_cast<std::int16_t>(in.reach);
  for (int x = 0; x < width; ++x) {
    const std::int16_t z = centre[x];
    std::int16_t sum = 0;
    std::int16_t count = 1;
    for (int i = 0; i < in.neighbours; ++i) {
      // The difference to an unknown one wraps to something far away, whatever z is.
      const auto d = static_cast<std::int16_t>(in.neighbour[i][x] - z);
      const bool near = d <= reach && d >= -reach;
      sum = static_cast<std::int16_t>(sum + (near ? d : 0));
      count = static_cast<std::int16_t>(count + (near ? 1 : 0));
    }
    const int mean = (sum * in.scale * kReciprocals[count] + (1 << 14)) >> 15;
    const int value = z * in.scale + mean;
    out[x] = z == kUnknownDisparity ? kUnknownDisparity : static_cast<std::int16_t>((value + in.round) >> in.shift);
  }
}
