// SPDX-License-Identifier: BSD-3-Clause
// The text of a times file as rows of words: what parts them, which commas are decimal ones, and what is a heading.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cliquevo::drivers {

struct TimesRow {
  int line = 0;
  std::string_view text;  // of the whole row
  std::vector<std::string> words;
};

struct TimesText {
  std::string heading;
  bool bare_heading = false;  // without '#'
  std::vector<std::string> heading_words;
  std::vector<TimesRow> rows;
};

// Words are parted by blanks, tabs, semicolons and (where they are not decimal) commas; what stands in quotes stays
// together. A first line that is text is a heading, with '#' or without. The views point into `text`.
TimesText split_times(std::string_view text);

}  // namespace cliquevo::drivers
