// SPDX-License-Identifier: BSD-3-Clause
#include "tools/stroke_font.h"

#include <array>

namespace cliquevo::tools {

namespace {

// From the blank on, in the order of ASCII. A point is a digit (x) and a letter (y: a = 2 below the baseline, c = on
// it, g = small letters, i = capitals).
constexpr std::array<Glyph, 95> kGlyphs{{
    {2, ""},                                  // blank
    {0, "0i0e 0c0c"},                         // !
    {2, "0i0g 2i2g"},                         // "
    {4, "1c1i 3c3i 0e4e 0g4g"},               // #
    {4, "4h3i1i0h0g1f3f4e4d3c1c0d 2j2b"},     // $
    {4, "0c4i 0i1i1h0h0i 3d4d4c3c3d"},        // %
    {4, "4c1g1h2i3h3g0e0d1c2c4e"},            // &
    {0, "0i0g"},                              // '
    {1, "1i0h0d1c"},                          // (
    {1, "0i1h1d0c"},                          // )
    {4, "2h2d 0g4e 4g0e"},                    // *
    {4, "2h2d 0f4f"},                         // +
    {1, "1c0b"},                              // ,
    {3, "0f3f"},                              // -
    {0, "0c0c"},                              // .
    {3, "0c3i"},                              // /
    {3, "1c0d0h1i2i3h3d2c1c"},                // 0
    {1, "0h1i1c"},                            // 1
    {3, "0h1i2i3h3g0c3c"},                    // 2
    {3, "0h1i2i3h3g2f1f 2f3e3d2c1c0d"},       // 3
    {3, "2c2i0e3e"},                          // 4
    {3, "3i0i0f2f3e3d2c1c0d"},                // 5
    {3, "3h2i1i0h0d1c2c3d3e2f1f0e"},          // 6
    {3, "0i3i1c"},                            // 7
    {3, "1f0g0h1i2i3h3g2f1f0e0d1c2c3d3e2f"},  // 8
    {3, "3g2f1f0g0h1i2i3h3d2c1c0d"},          // 9
    {0, "0g0g 0d0d"},                         // :
    {1, "1g1g 1c0b"},                         // ;
    {4, "4h0f4d"},                            // <
    {4, "0g4g 0e4e"},                         // =
    {4, "0h4f0d"},                            // >
    {3, "0h1i2i3h3g1f1e 1c1c"},               // ?
    {4, "3e3g1g1e4e4h3i1i0h0d1c4c"},          // @
    {4, "0c2i4c 1e3e"},                       // A
    {4, "0c0i3i4h4g3f0f 3f4e4d3c0c"},         // B
    {4, "4h3i1i0h0d1c3c4d"},                  // C
    {4, "0c0i3i4h4d3c0c"},                    // D
    {3, "3i0i0c3c 0f2f"},                     // E
    {3, "3i0i0c 0f2f"},                       // F
    {4, "4h3i1i0h0d1c3c4d4f2f"},              // G
    {4, "0i0c 4i4c 0f4f"},                    // H
    {0, "0i0c"},                              // I
    {3, "3i3d2c1c0d"},                        // J
    {4, "0i0c 4i0e 1f4c"},                    // K
    {3, "0i0c3c"},                            // L
    {4, "0c0i2f4i4c"},                        // M
    {4, "0c0i4c4i"},                          // N
    {4, "1c0d0h1i3i4h4d3c1c"},                // O
    {4, "0c0i3i4h4g3f0f"},                    // P
    {4, "1c0d0h1i3i4h4d3c1c 2e4c"},           // Q
    {4, "0c0i3i4h4g3f0f 2f4c"},               // R
    {4, "4h3i1i0h0g1f3f4e4d3c1c0d"},          // S
    {4, "0i4i 2i2c"},                         // T
    {4, "0i0d1c3c4d4i"},                      // U
    {4, "0i2c4i"},                            // V
    {4, "0i1c2f3c4i"},                        // W
    {4, "0i4c 4i0c"},                         // X
    {4, "0i2f4i 2f2c"},                       // Y
    {4, "0i4i0c4c"},                          // Z
    {1, "1i0i0c1c"},                          // [
    {3, "0i3c"},                              // backslash
    {1, "0i1i1c0c"},                          // ]
    {4, "0g2i4g"},                            // ^
    {4, "0b4b"},                              // _
    {1, "0i1h"},                              // `
    {3, "0g2g3f3c 3e1e0d1c2c3d"},             // a
    {3, "0i0c 0f1g2g3f3d2c1c0d"},             // b
    {3, "3f2g1g0f0d1c2c3d"},                  // c
    {3, "3i3c 3f2g1g0f0d1c2c3d"},             // d
    {3, "0e3e3f2g1g0f0d1c2c3d"},              // e
    {3, "3i2i1h1c 0g2g"},                     // f
    {3, "3g3b2a1a0b 3f2g1g0f0d1c2c3d"},       // g
    {3, "0i0c 0f1g2g3f3c"},                   // h
    {0, "0g0c 0i0i"},                         // i
    {1, "1g1b0a 1i1i"},                       // j
    {3, "0i0c 3g0e3c"},                       // k
    {1, "0i0d1c"},                            // l
    {4, "0g0c 0f1g2f2c 2f3g4f4c"},            // m
    {3, "0g0c 0f1g2g3f3c"},                   // n
    {3, "1c0d0f1g2g3f3d2c1c"},                // o
    {3, "0g0a 0f1g2g3f3d2c1c0d"},             // p
    {3, "3g3a 3f2g1g0f0d1c2c3d"},             // q
    {2, "0g0c 0f1g2g"},                       // r
    {3, "3f2g1g0f1e2e3d2c1c0d"},              // s
    {3, "1i1d2c3c 0g3g"},                     // t
    {3, "0g0d1c2c3d 3g3c"},                   // u
    {4, "0g2c4g"},                            // v
    {4, "0g1c2f3c4g"},                        // w
    {3, "0g3c 3g0c"},                         // x
    {4, "0g2c 4g1a0a"},                       // y
    {3, "0g3g0c3c"},                          // z
    {2, "2i1h1g0f1e1d2c"},                    // {
    {0, "0i0b"},                              // |
    {2, "0i1h1g2f1e1d0c"},                    // }
    {4, "0f1g3e4f"},                          // ~
}};

GlyphPoint point_at(std::string_view strokes, std::size_t i) {
  return {static_cast<double>(strokes[i] - '0'), static_cast<double>(strokes[i + 1] - 'c')};
}

}  // namespace

Glyph glyph_of(char c) {
  const bool known = c >= ' ' && c <= '~';
  return kGlyphs[static_cast<std::size_t>((known ? c : '?') - ' ')];
}

std::vector<std::pair<GlyphPoint, GlyphPoint>> strokes_of(const Glyph& glyph) {
  std::vector<std::pair<GlyphPoint, GlyphPoint>> out;
  const std::string_view s = glyph.strokes;
  for (std::size_t i = 0; i + 3 < s.size(); i += 2) {
    if (s[i + 2] == ' ') {
      ++i;  // over the blank; the next point begins a stroke
      continue;
    }
    out.emplace_back(point_at(s, i), point_at(s, i + 2));
  }
  return out;
}

}  // namespace cliquevo::tools
