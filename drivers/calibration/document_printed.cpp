// SPDX-License-Identifier: BSD-3-Clause
// Matrices as programs print them: numpy, MATLAB, Bouguet's toolbox, people.
#include <algorithm>

#include "drivers/calibration/document.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

using Kind = DocumentNode::Kind;

constexpr std::size_t kMostNames = 2000;
constexpr std::size_t kMostText = 10000;  // of one value

bool is_bracket(char c) { return c == '[' || c == ']' || c == '(' || c == ')' || c == ';' || c == '\'' || c == '"'; }

std::string without_brackets(std::string_view text) {
  std::string out(text);
  std::replace_if(out.begin(), out.end(), is_bracket, ' ');
  return out;
}

bool is_numbers(std::string_view text) {
  const auto numbers = parse_numbers(text, "", "");
  return numbers && !numbers->empty();
}

// "ROTATION MATRIX (R)" is a rotation matrix.
std::string without_remarks(std::string name) {
  for (std::size_t end = name.find(')'); end != std::string::npos; end = name.find(')')) {
    const std::size_t begin = name.rfind('(', end);
    if (begin == std::string::npos) break;
    name.erase(begin, end - begin + 1);
  }
  return name;
}

struct PrintedLine {
  std::string name;   // empty: numbers alone
  std::string value;  // empty: none in this line
  bool section = false;
};

// "Focal length: fc = [ 1 2 ] +- [ 3 4 ]" is fc; "R:" and "translation =" have their numbers below.
PrintedLine parse_line(std::string_view text) {
  std::string line(text);
  // Behind a value: its deviation, as "+-" or as the sign in UTF-8 or Latin-1; a remark of MATLAB's.
  for (const char* end : {"+-", "\xC2\xB1", " \xB1", " %", ";%", "\t%"}) {
    if (const std::size_t at = line.find(end); at != std::string::npos) line.resize(at);
  }
  std::string plain = without_brackets(line);
  if (is_numbers(plain)) return {"", plain, false};
  const std::size_t equals = line.find('=');
  const std::size_t colon = line.find(':');
  const std::size_t cut = equals != std::string::npos && equals > 0 ? equals : colon;
  if (cut == std::string::npos || cut == 0) return {};
  std::string name = line.substr(0, cut);
  if (const std::size_t before = name.rfind(':'); before != std::string::npos) name.erase(0, before + 1);
  std::string value = without_brackets(line.substr(cut + 1));
  std::replace(value.begin(), value.end(), ',', ' ');
  name = without_brackets(without_remarks(std::move(name)));
  const bool numbers = is_numbers(value);
  return {std::string(trim(name)), numbers ? value : "", !numbers && trim(value).empty()};
}

}  // namespace

Result<Document> Document::parse_printed(std::string_view text, const std::string& path) {
  DocumentNode root;
  root.kind = Kind::map;
  std::string name;
  std::string section;
  DocumentNode value;
  std::size_t count = 0;
  const auto finish = [&] {
    if (!value.scalar.empty() && ++count < kMostNames) {
      value.kind = Kind::scalar;
      root.entries.push_back({section.empty() ? name : section + "." + name, value});
    } else if (!name.empty()) {
      section = name;
    }
    value = {};
  };
  for (const TextLine& line : split_lines(text)) {
    if (line.text.front() == '=' || line.text.front() == '%') continue;
    const PrintedLine printed = parse_line(line.text);
    if (!printed.name.empty() && (printed.section || !printed.value.empty())) {
      finish();
      name = printed.name;
      value.scalar = printed.value;
      value.line = line.number;
    } else if (printed.name.empty() && !printed.value.empty() && !name.empty()) {
      if (value.scalar.size() < kMostText) value.scalar += " " + printed.value;
    } else {
      finish();
      name.clear();
    }
  }
  finish();
  return of(std::move(root), path);
}

}  // namespace cliquevo::drivers
