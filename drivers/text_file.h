// SPDX-License-Identifier: BSD-3-Clause
// Small text files (times, calibrations): read whole, split into lines, numbers parsed strictly.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

// The whole of a regular file, in UTF-8 also where it is UTF-16. Errors: missing, no regular file, unreadable, empty,
// above max_bytes, NUL bytes. `kind` names it in the message: "times file".
Result<std::string> read_text_file(const std::string& path, const std::string& kind, std::size_t max_bytes);
// As it is, whatever its bytes; errors as above.
Result<std::string> read_whole_file(const std::string& path, const std::string& kind, std::size_t max_bytes);

// Text in UTF-16, of either order, with its mark or without, as UTF-8; any other as it is.
std::string utf8_of(std::string text);

struct TextLine {
  int number = 0;  // from 1
  std::string_view text;
};

// Lines without comments (from '#') and outer blanks; empty ones are left out. The views point into `text`.
std::vector<TextLine> split_lines(std::string_view text);
// Words between blanks, commas or both.
std::vector<std::string_view> split_words(std::string_view text);
std::string_view trim(std::string_view text);

// Control characters and bytes beyond ASCII shown as '?', for messages about junk.
std::string printable(std::string_view text);

// A finite decimal number and nothing else.
std::optional<double> parse_number(std::string_view text);
// Finite numbers; the Error's `what` names the bad word and why; `where` and `kind` are the caller's.
Result<std::vector<double>> parse_numbers(std::string_view text, const std::string& kind, const std::string& where);
// Decimal seconds to ns without going through a double (1.6e9 s would lose 200 ns); exponents allowed.
std::optional<TimestampNs> parse_seconds(std::string_view text);
std::optional<std::int64_t> parse_integer(std::string_view text);

}  // namespace cliquevo::drivers
