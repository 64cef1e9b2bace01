// SPDX-License-Identifier: BSD-3-Clause
// Letters as strokes of a pen.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

namespace cliquevo::tools {

inline constexpr double kCapitalHeight = 6.0;  // in the font's units

struct Glyph {
  int width = 0;             // units, without the gap behind it
  std::string_view strokes;  // two characters a point, strokes apart by a blank
};
// What is not printable ASCII becomes a question mark.
Glyph glyph_of(char c);

struct GlyphPoint {
  double x = 0.0;  // to the right
  double y = 0.0;  // up from the baseline
};
std::vector<std::pair<GlyphPoint, GlyphPoint>> strokes_of(const Glyph& glyph);

}  // namespace cliquevo::tools
