// SPDX-License-Identifier: BSD-3-Clause
// YAML (and JSON), OpenCV's XML and INI to the same tree. Depth and number of nodes are bounded: aliases in YAML
// cannot make more of a small file.
#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "drivers/calibration/document.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

using Kind = DocumentNode::Kind;

constexpr int kMostNodes = 50000;
constexpr int kDeepest = 16;

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; }

// A key's colon with its value right behind it: "data:[", "rows:3", "dt:d" of a matrix, and any at a line's beginning.
bool is_tight(std::string_view text, std::size_t colon) {
  if (colon == 0 || !is_word(text[colon - 1]) || colon + 1 >= text.size()) return false;
  const char next = text[colon + 1];
  if (next == '[') return true;
  std::size_t begin = colon;
  while (begin > 0 && is_word(text[begin - 1])) --begin;
  const std::string_view key = text.substr(begin, colon - begin);
  const bool of_a_matrix = key == "rows" || key == "cols" || key == "dt";
  if (of_a_matrix) return is_word(next) && (begin == 0 || text[begin - 1] == ' ' || text[begin - 1] == '\n');
  while (begin > 0 && text[begin - 1] == ' ') --begin;
  const bool first = begin == 0 || text[begin - 1] == '\n';
  return first && std::isalpha(static_cast<unsigned char>(key.front())) != 0 &&
         (is_word(next) || next == '-' || next == '+' || next == '"');
}

// What OpenCV's parser takes and YAML does not, made YAML; the lines stay.
std::string as_yaml(std::string_view text) {
  std::string out;
  out.reserve(text.size() + 64);
  bool head = text.substr(0, 5) == "%YAML";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') head = false;
    if (head || c == '\t' || c == '\r') {
      out += ' ';
      continue;
    }
    out += c;
    if (c == ':' && is_tight(text, i)) out += ' ';
  }
  return out;
}

Result<DocumentNode> convert(const YAML::Node& node, const std::string& path, int depth, int& budget) {
  DocumentNode out;
  out.line = node.Mark().line + 1;
  if (depth > kDeepest || --budget < 0) {
    return Error{"calibration is nested too deep or too large", fmt::format("{}:{}", path, out.line),
                 "name a calibration file"};
  }
  if (node.IsScalar()) {
    out.kind = Kind::scalar;
    out.scalar = node.Scalar();
  } else if (node.IsSequence()) {
    out.kind = Kind::list;
    for (const YAML::Node& item : node) {
      Result<DocumentNode> inner = convert(item, path, depth + 1, budget);
      if (!inner) return inner;
      out.items.push_back(std::move(*inner));
    }
  } else if (node.IsMap()) {
    out.kind = Kind::map;
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) continue;
      Result<DocumentNode> inner = convert(entry.second, path, depth + 1, budget);
      if (!inner) return inner;
      out.entries.push_back({entry.first.Scalar(), std::move(*inner)});
    }
  } else {
    out.kind = Kind::empty;
  }
  return out;
}

// OpenCV's XML: tags with text or tags, no more. Attributes, comments and heads are passed over.
class XmlParser {
 public:
  XmlParser(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  Result<DocumentNode> parse() {
    for (;;) {
      skip_to_tag();
      if (at_ >= text_.size()) return torn("no tag");
      if (!skip_comment_or_head()) break;
    }
    std::string name;
    return element(0, name);
  }

 private:
  Error torn(const std::string& what) const {
    return {fmt::format("calibration is no valid XML ({})", what), fmt::format("{}:{}", path_, line_),
            "copy it again: it may be torn"};
  }
  void advance(std::size_t to) {
    to = std::min(to, text_.size());
    for (; at_ < to; ++at_) line_ += text_[at_] == '\n' ? 1 : 0;
  }
  void skip_to_tag() { advance(text_.find('<', at_)); }
  // True where at_ was at one of them; behind it then.
  bool skip_comment_or_head() {
    for (const auto& [begin, end] : {std::pair{"<!--", "-->"}, {"<?", "?>"}, {"<!", ">"}}) {
      if (text_.substr(at_, std::string_view(begin).size()) != begin) continue;
      const std::size_t stop = text_.find(end, at_);
      advance(stop == std::string_view::npos ? stop : stop + std::string_view(end).size());
      return true;
    }
    return false;
  }
  // at_ is at the '<' of a start tag.
  Result<DocumentNode> element(int depth, std::string& name) {
    DocumentNode out;
    out.line = line_;
    if (depth > kDeepest || --budget_ < 0) return torn("nested too deep or too large");
    const std::size_t close = text_.find('>', at_);
    if (close == std::string_view::npos || close == at_ + 1) return torn("a tag without end");
    std::string_view tag = text_.substr(at_ + 1, close - at_ - 1);
    const bool alone = tag.back() == '/';
    name = std::string(tag.substr(0, tag.find_first_of(" \t\r\n/")));
    if (name.empty()) return torn("a tag without name");
    advance(close + 1);
    out.kind = Kind::empty;
    if (alone) return out;
    std::string words;
    for (;;) {
      const std::size_t next = text_.find('<', at_);
      if (next == std::string_view::npos) return torn(fmt::format("<{}> has no end", printable(name.substr(0, 32))));
      words += text_.substr(at_, next - at_);
      advance(next);
      if (skip_comment_or_head()) continue;
      if (text_.substr(at_, 2) == "</") break;
      std::string inner_name;
      Result<DocumentNode> inner = element(depth + 1, inner_name);
      if (!inner) return inner;
      if (inner_name == "_") {  // an item of a list
        out.kind = Kind::list;
        out.items.push_back(std::move(*inner));
      } else {
        out.kind = Kind::map;
        out.entries.push_back({inner_name, std::move(*inner)});
      }
    }
    const std::size_t stop = text_.find('>', at_);
    if (stop == std::string_view::npos || trim(text_.substr(at_ + 2, stop - at_ - 2)) != name) {
      return torn(fmt::format("<{}> has no end", printable(name.substr(0, 32))));
    }
    advance(stop + 1);
    if (out.kind != Kind::empty) return out;
    std::string_view value = trim(words);
    if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
    if (!value.empty()) {
      out.kind = Kind::scalar;
      out.scalar = std::string(value);
    }
    return out;
  }

  std::string_view text_;
  std::string path_;
  std::size_t at_ = 0;
  int line_ = 1;
  int budget_ = kMostNodes;
};

// A line of an INI without what stands behind "//", as MRPT writes it; addresses keep theirs.
std::string_view without_remark(std::string_view line) {
  for (std::size_t at = line.find("//"); at != std::string_view::npos; at = line.find("//", at + 1)) {
    if (at == 0 || line[at - 1] == ' ' || line[at - 1] == '\t' || line[at - 1] == ']') return line.substr(0, at);
  }
  return line;
}

}  // namespace

Result<Document> Document::parse_yaml(std::string_view text, const std::string& path) {
  try {
    int budget = kMostNodes;
    const YAML::Node root = YAML::Load(as_yaml(text));
    Result<DocumentNode> node = convert(root, path, 0, budget);
    if (!node) return node.error();
    if (node->kind != Kind::map) {
      return Error{"calibration is of no known format", path, "expected YAML with keys and values"};
    }
    return of(std::move(*node), path);
  } catch (const YAML::Exception& e) {
    return Error{fmt::format("calibration is no valid YAML ({})", printable(e.msg)),
                 fmt::format("{}:{}", path, e.mark.line + 1), "copy it again: it may be torn"};
  }
}

Result<Document> Document::parse_xml(std::string_view text, const std::string& path) {
  Result<DocumentNode> node = XmlParser(text, path).parse();
  if (!node) return node.error();
  if (node->kind != Kind::map) {
    return Error{"calibration is of no known format", path, "expected OpenCV's XML with keys and values"};
  }
  return of(std::move(*node), path);
}

Result<Document> Document::parse_ini(std::string_view text, const std::string& path) {
  DocumentNode root;
  root.kind = Kind::map;
  std::size_t section = 0;  // of root's entries, from 1
  int budget = kMostNodes;
  for (const TextLine& line : split_lines(text)) {
    if (line.text.front() == ';') continue;
    if (--budget < 0) return Error{"calibration is too large", path, "name a calibration file"};
    if (line.text.front() == '[') {
      const std::size_t close = line.text.find(']');
      if (close == std::string_view::npos) {
        return Error{"section has no end", fmt::format("{}:{}", path, line.number), "copy the calibration again"};
      }
      DocumentNode node;
      node.kind = Kind::map;
      node.line = line.number;
      root.entries.push_back({std::string(trim(line.text.substr(1, close - 1))), std::move(node)});
      section = root.entries.size();
      continue;
    }
    const std::string_view content = without_remark(line.text);
    const std::size_t equals = content.find_first_of("=:");
    if (equals == std::string_view::npos) continue;
    DocumentNode value;
    value.kind = Kind::scalar;
    value.line = line.number;
    value.scalar = std::string(trim(content.substr(equals + 1)));
    std::replace_if(
        value.scalar.begin(), value.scalar.end(), [](char c) { return c == '[' || c == ']' || c == ';'; }, ' ');
    DocumentNode& map = section == 0 ? root : root.entries[section - 1].node;
    map.entries.push_back({std::string(trim(content.substr(0, equals))), std::move(value)});
  }
  return of(std::move(root), path);
}

}  // namespace cliquevo::drivers
