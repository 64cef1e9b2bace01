// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/times_rows.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "drivers/recording/dates.h"
#include "drivers/recording/letters.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

// Brackets are those of printed lists.
bool is_between(char c) { return std::string_view(" \t;\r[]()").find(c) != std::string_view::npos; }
bool is_quote(char c) { return c == '"' || c == '\''; }

bool all_digits(std::string_view text) { return !text.empty() && std::all_of(text.begin(), text.end(), is_digit); }

// How the rows of one file are parted into words.
struct Parting {
  bool commas = true;           // part words
  bool decimal_commas = false;  // stand for a point inside numbers
};

// Quotes keep what is between them together, and go.
std::vector<std::string> part(std::string_view line, const Parting& parting) {
  std::vector<std::string> words;
  std::string word;
  bool begun = false;
  char quote = 0;
  const auto end_word = [&] {
    if (begun) words.push_back(std::string(trim(word)));
    word.clear();
    begun = false;
  };
  for (const char c : line) {
    if (quote != 0 ? c == quote : is_quote(c)) {
      quote = quote != 0 ? '\0' : c;
      begun = true;
    } else if (quote == 0 && (is_between(c) || (c == ',' && parting.commas))) {
      end_word();
    } else {
      word += c;
      begun = true;
    }
  }
  end_word();
  for (std::string& w : words) {
    const std::size_t comma = w.find(',');
    if (!parting.decimal_commas || comma == std::string::npos || w.find(',', comma + 1) != std::string::npos) continue;
    std::string number = w;
    number[comma] = '.';
    if (parse_seconds(number)) w = number;
  }
  return words;
}

// "0,100": the digits on both sides of the only comma of a word without anything else.
std::optional<std::pair<std::string, std::string>> around_comma(const std::string& word) {
  const std::size_t comma = word.find(',');
  if (comma == std::string::npos) return std::nullopt;
  std::string before = word.substr(0, comma);
  std::string after = word.substr(comma + 1);
  if (!all_digits(before) || !all_digits(after)) return std::nullopt;
  return std::pair{before, after};
}

bool rises(const std::vector<std::int64_t>& values) {
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] <= values[i - 1]) return false;
  }
  return values.size() > 1;
}

// Whether the commas of rows that are not parted otherwise are decimal ones: as many digits behind each, and not two
// columns of which each makes sense alone (a number that counts, or one that stands still, beside one that rises).
bool commas_are_decimal(const std::vector<TextLine>& lines) {
  std::vector<std::int64_t> before;
  std::vector<std::int64_t> after;
  std::size_t digits = 0;
  for (const TextLine& line : lines) {
    if (std::count(line.text.begin(), line.text.end(), ',') != 1) return false;
    for (const std::string& word : part(line.text, {false, false})) {
      const auto sides = around_comma(word);
      if (!sides) continue;
      if (digits != 0 && sides->second.size() != digits) return false;
      digits = sides->second.size();
      const auto whole = parse_integer(sides->first);
      if (digits > 9 || !whole) return false;
      before.push_back(*whole);
      after.push_back(*parse_integer(sides->second));
    }
  }
  if (before.size() != lines.size()) return false;
  const bool still = std::equal(after.begin() + 1, after.end(), after.begin());
  return !(rises(before) && (still || rises(after)));
}

Parting parting_of(const std::vector<TextLine>& lines) {
  const auto has = [&](char c) {
    const auto rows = std::count_if(lines.begin(), lines.end(),
                                    [c](const TextLine& l) { return l.text.find(c) != std::string_view::npos; });
    return 2 * static_cast<std::size_t>(rows) > lines.size();
  };
  const bool quoted_commas = std::any_of(lines.begin(), lines.end(), [](const TextLine& l) {
    const std::vector<std::string> words = part(l.text, {true, false});
    return std::any_of(words.begin(), words.end(), [](const std::string& w) { return around_comma(w).has_value(); });
  });
  if (quoted_commas) return {true, true};
  if (has(';') || has('\t')) return {false, true};
  if (!lines.empty() && commas_are_decimal(lines)) return {false, true};
  return {true, false};
}

// Words, none of which begins with a digit or is a number.
bool is_heading(const TextLine& line) {
  if (find_date_time(line.text)) return false;
  const std::vector<std::string> words = part(line.text, {});
  const auto is_number = [](const std::string& w) {
    const std::string l = lower(w);
    return l.empty() || is_digit(l.front()) || l == "nan" || l == "inf" || parse_seconds(l).has_value();
  };
  return std::none_of(words.begin(), words.end(), is_number) &&
         std::any_of(line.text.begin(), line.text.end(), is_letter);
}

// "[0.0, 0.1, 0.2]": a list of times in one line is a row a time.
void part_list(std::vector<TimesRow>& rows) {
  if (rows.size() != 1 || rows[0].words.size() < 3) return;
  const std::string_view text = trim(rows[0].text);
  const auto is_time = [](const std::string& w) { return parse_seconds(w).has_value(); };
  if (text.front() != '[' || text.back() != ']') return;
  if (!std::all_of(rows[0].words.begin(), rows[0].words.end(), is_time)) return;
  const TimesRow list = std::exchange(rows[0], {});
  rows.clear();
  for (const std::string& word : list.words) rows.push_back({list.line, list.text, {word}});
}

}  // namespace

TimesText split_times(std::string_view text) {
  TimesText out;
  std::vector<TextLine> lines = split_lines(text);
  const std::string_view first_line = trim(text.substr(0, text.find('\n')));
  if (!first_line.empty() && first_line.front() == '#') out.heading = std::string(trim(first_line.substr(1)));
  out.bare_heading = lines.size() > 1 && is_heading(lines.front());
  if (out.bare_heading) {
    out.heading = std::string(lines.front().text);
    lines.erase(lines.begin());
  }
  const Parting parting = parting_of(lines);
  for (const TextLine& line : lines) out.rows.push_back({line.number, line.text, part(line.text, parting)});
  part_list(out.rows);
  // A heading's words may hold blanks where something else parts them.
  const char* parts = out.heading.find(';') != std::string::npos   ? ";"
                      : out.heading.find(',') != std::string::npos ? ","
                                                                   : " \t";
  std::string_view rest = out.heading;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find_first_of(parts), rest.size());
    if (end > 0) out.heading_words.emplace_back(trim(rest.substr(0, end)));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return out;
}

}  // namespace cliquevo::drivers
