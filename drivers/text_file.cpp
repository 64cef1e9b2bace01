// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/text_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>

#include <fmt/format.h>

namespace cliquevo::drivers {

namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

bool is_blank(char c) { return kBlanks.find(c) != std::string_view::npos; }

std::string quoted(std::string_view word) {
  return fmt::format("'{}{}'", printable(word.substr(0, 32)), word.size() > 32 ? "..." : "");
}

void append_utf8(std::uint32_t code, std::string& out) {
  const auto byte = [&out](std::uint32_t value) { out += static_cast<char>(value); };
  if (code < 0x80U) {
    byte(code);
  } else if (code < 0x800U) {
    byte(0xC0U | code >> 6U), byte(0x80U | (code & 0x3FU));
  } else if (code < 0x10000U) {
    byte(0xE0U | code >> 12U), byte(0x80U | (code >> 6U & 0x3FU)), byte(0x80U | (code & 0x3FU));
  } else {
    byte(0xF0U | code >> 18U), byte(0x80U | (code >> 12U & 0x3FU)), byte(0x80U | (code >> 6U & 0x3FU));
    byte(0x80U | (code & 0x3FU));
  }
}

}  // namespace

std::string utf8_of(std::string text) {
  const auto byte = [&text](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  if (text.size() < 2 || text.size() % 2 != 0) return text;
  bool little = byte(0) == 0xFFU && byte(1) == 0xFEU;
  const bool big = byte(0) == 0xFEU && byte(1) == 0xFFU;
  const bool marked = little || big;
  if (!marked) {  // plain text whose every second byte is nothing
    std::size_t even = 0;
    std::size_t odd = 0;
    for (std::size_t i = 0; i < text.size(); i += 2) even += text[i] == 0 ? 1 : 0, odd += text[i + 1] == 0 ? 1 : 0;
    if (2 * std::max(even, odd) != text.size() || std::min(even, odd) != 0) return text;
    little = odd > even;
  }
  std::string out;
  for (std::size_t i = marked ? 2 : 0; i + 1 < text.size(); i += 2) {
    const auto unit = [&](std::size_t at) {
      return little ? byte(at + 1) << 8U | byte(at) : byte(at) << 8U | byte(at + 1);
    };
    std::uint32_t code = unit(i);
    if (code >= 0xD800U && code < 0xDC00U && i + 3 < text.size() && unit(i + 2) >= 0xDC00U && unit(i + 2) < 0xE000U) {
      code = 0x10000U + ((code - 0xD800U) << 10U) + (unit(i + 2) - 0xDC00U);
      i += 2;
    }
    append_utf8(code, out);
  }
  return out;
}

Result<std::string> read_whole_file(const std::string& path, const std::string& kind, std::size_t max_bytes) {
  namespace fs = std::filesystem;
  std::error_code ec;
  const fs::file_status status = fs::status(path, ec);
  if (!fs::exists(status)) return Error{"no " + kind, path, "check the name"};
  // A pipe or device would block or never end.
  if (!fs::is_regular_file(status)) return Error{"cannot read " + kind, path, "name a regular file"};
  const std::uintmax_t size = fs::file_size(path, ec);
  if (ec) return Error{"cannot read " + kind, path, ec.message()};
  if (size == 0) return Error{kind + " is empty", path, "copy it again"};
  if (size > max_bytes) {
    return Error{kind + " is too big", path, "name a file of at most " + std::to_string(max_bytes) + " bytes"};
  }
  std::ifstream in(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    return Error{"cannot read " + kind, path, "check its permissions and the disk"};
  }
  return text;
}

Result<std::string> read_text_file(const std::string& path, const std::string& kind, std::size_t max_bytes) {
  Result<std::string> whole = read_whole_file(path, kind, max_bytes);
  if (!whole) return whole;
  std::string text = utf8_of(std::move(*whole));
  if (text.find('\0') != std::string::npos) {
    return Error{kind + " holds NUL bytes", path,
                 "it is torn (copy it again) or no text (NumPy, MATLAB, pickle: save it as YAML or JSON)"};
  }
  if (text.compare(0, 3, "\xEF\xBB\xBF") == 0) text.erase(0, 3);
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');  // of an old Mac
  return text;
}

std::string printable(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 32 && c < 127 ? c : '?';
  return out;
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<TextLine> split_lines(std::string_view text) {
  std::vector<TextLine> lines;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    line = trim(line.substr(0, line.find('#')));
    if (!line.empty()) lines.push_back({number, line});
  }
  return lines;
}

std::vector<std::string_view> split_words(std::string_view text) {
  std::vector<std::string_view> words;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i < text.size() && !is_blank(text[i]) && text[i] != ',') continue;
    if (i > begin) words.push_back(text.substr(begin, i - begin));
    begin = i + 1;
  }
  return words;
}

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
    if (!text.empty() && text.front() == '-') return std::nullopt;
  }
  double value = 0.0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (ec != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

Result<std::vector<double>> parse_numbers(std::string_view text, const std::string& kind, const std::string& where) {
  std::vector<double> values;
  for (const std::string_view word : split_words(text)) {
    const std::optional<double> value = parse_number(word);
    if (!value) return Error{kind + " holds " + quoted(word), where, "put a finite number there"};
    values.push_back(*value);
  }
  return values;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (ec != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<TimestampNs> parse_seconds(std::string_view text) {
  bool negative = false;
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  // value = mantissa * 10^exponent; digits beyond what an int64 holds are below a nanosecond, or too much anyway.
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  std::int64_t mantissa = 0;
  int exponent = 9;  // seconds -> ns
  bool any = false;
  bool point = false;
  bool full = false;
  std::size_t i = 0;
  for (; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.' && !point) {
      point = true;
      continue;
    }
    if (c < '0' || c > '9') break;
    any = true;
    full = full || mantissa > (kMost - 9) / 10;
    if (!full) mantissa = mantissa * 10 + (c - '0');
    if (full && !point && exponent < 100) ++exponent;
    if (!full && point) --exponent;
  }
  if (!any) return std::nullopt;
  if (i < text.size()) {
    if (text[i] != 'e' && text[i] != 'E') return std::nullopt;
    std::string_view power = text.substr(i + 1);
    if (!power.empty() && power.front() == '+') power.remove_prefix(1);
    const std::optional<std::int64_t> e = parse_integer(power);
    if (!e || *e > 1000 || *e < -1000) return std::nullopt;
    exponent += static_cast<int>(*e);
  }
  for (; exponent > 0 && mantissa != 0; --exponent) {
    if (mantissa > kMost / 10) return std::nullopt;
    mantissa *= 10;
  }
  for (; exponent < -1 && mantissa != 0; ++exponent) mantissa /= 10;
  if (exponent == -1) mantissa = (mantissa + 5) / 10;
  return negative ? -mantissa : mantissa;
}

}  // namespace cliquevo::drivers
