// SPDX-License-Identifier: BSD-3-Clause
#include "tools/config_pages.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/vo/verdict.h"
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::tools {

namespace {

using daemon::Choice;
using daemon::Config;
using daemon::Key;
using daemon::KeyTable;
using daemon::Section;
using nlohmann::ordered_json;

constexpr std::size_t kWidth = 120;

// The compiled defaults and the table over them.
struct Defaults {
  Config config = daemon::default_config();
  KeyTable table = daemon::config_keys(config);
};

std::size_t depth_of(const std::string& name) {
  return static_cast<std::size_t>(std::count(name.begin(), name.end(), '.'));
}
std::string last_part(const std::string& name) { return name.substr(name.rfind('.') + 1); }
std::string section_of(const Key& key) { return key.name.substr(0, key.name.rfind('.')); }

const Choice* choice_of(const Key& key) { return std::get_if<Choice>(&key.field); }
bool is_text(const Key& key) {
  return std::holds_alternative<std::string*>(key.field) || std::holds_alternative<daemon::FilePath>(key.field);
}

// Unit, range or names, as they stand behind a meaning: "px; 5 to 21, odd".
std::string limits(const Key& key) {
  std::vector<std::string> parts;
  if (!key.unit.empty()) parts.push_back(key.unit);
  if (const Choice* choice = choice_of(key)) parts.push_back(fmt::format("{}", fmt::join(choice->names, ", ")));
  std::string range = key.range.text();
  if (!range.empty() && is_text(key)) range += " characters";
  if (!range.empty()) parts.push_back(range);
  return fmt::format("{}", fmt::join(parts, "; "));
}

// Words that fit behind `indent`, line by line.
std::vector<std::string> wrapped_lines(const std::string& text, std::size_t width) {
  std::vector<std::string> lines{""};
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    begin = end + 1;
  }
  return lines;
}

// A value as YAML takes it. "off" would be read as false.
std::string yaml_value(const Key& key) {
  const std::string value = key.value();
  if (is_text(key)) {
    const std::string plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-/";
    return value.empty() || value.find_first_not_of(plain) != std::string::npos ? fmt::format("\"{}\"", value) : value;
  }
  if (value == "off") return "\"off\"";
  const bool whole_double =
      std::holds_alternative<double*>(key.field) && value.find_first_of(".e") == std::string::npos;
  return whole_double ? value + ".0" : value;
}

// `text` and behind it, from column 30 on, the comment.
std::string commented(const std::string& text, const std::string& comment) {
  constexpr std::size_t kColumn = 30;
  std::string out = text;
  if (comment.empty()) return out + "\n";
  const std::size_t column = std::max(kColumn, text.size() + 2);
  bool first = true;
  for (const std::string& line : wrapped_lines(comment, kWidth - 2 - column)) {
    out += std::string(column - (first ? text.size() : 0), ' ') + "# " + line + "\n";
    first = false;
  }
  return out;
}

std::string sentence(const Key& key) {
  const std::string behind = limits(key);
  return behind.empty() ? key.meaning : fmt::format("{} [{}]", key.meaning, behind);
}

ordered_json schema_of(const Key& key) {
  ordered_json out;
  out["description"] = sentence(key);
  const auto number = [&](const char* type) {
    out["type"] = type;
    if (key.range.low) out[key.range.low_is_open ? "exclusiveMinimum" : "minimum"] = *key.range.low;
    if (key.range.high) out["maximum"] = *key.range.high;
    if (key.range.multiple_of != 1) out["multipleOf"] = key.range.multiple_of;
    if (key.range.odd) out["not"] = {{"multipleOf", 2}};
  };
  if (const Choice* choice = choice_of(key)) {
    out["enum"] = choice->names;
  } else if (std::holds_alternative<bool*>(key.field)) {
    out["type"] = "boolean";
  } else if (std::holds_alternative<daemon::Triple>(key.field)) {
    out["type"] = "array";
    out["items"] = {{"type", "number"}};
    out["minItems"] = out["maxItems"] = 3;
  } else if (is_text(key)) {
    out["type"] = {"string", "null"};
    if (key.range.low) out["minLength"] = *key.range.low;
    if (key.range.high) out["maxLength"] = *key.range.high;
  } else if (std::holds_alternative<std::optional<double>*>(key.field)) {
    number("number");
    ordered_json value = out;
    value.erase("description");
    out = {{"description", sentence(key)}, {"anyOf", {value, {{"const", "auto"}}}}};
  } else {
    number(std::holds_alternative<double*>(key.field) ? "number" : "integer");
  }
  return out;
}

}  // namespace

std::string config_sample() {
  const Defaults defaults;
  std::string out =
      "# SPDX-License-Identifier: BSD-3-Clause\n"
      "# Configuration of cliquevod and of `cliquevo replay --config`. Written by tools/generate: do not edit here.\n"
      "#\n"
      "# Every key there is, each with its default: leave out what you do not change. A key that is not known, a value "
      "of\n"
      "# the wrong kind or out of its range is an error with its line. Paths that are relative start from this file's "
      "folder.\n"
      "# In brackets: unit and range.\n";
  std::string section;
  std::string group;
  for (const Key& key : defaults.table.keys()) {
    const std::string indent(2 * depth_of(key.name), ' ');
    if (section_of(key) != section) {
      section = section_of(key);
      group.clear();
      const auto row = std::find_if(defaults.table.sections().begin(), defaults.table.sections().end(),
                                    [&](const Section& s) { return s.name == section; });
      out += "\n";
      out += commented(std::string(2 * depth_of(section), ' ') + last_part(section) + ":", row->meaning);
    }
    if (key.group != group) {
      group = key.group;
      out += "\n";
      for (const std::string& line : wrapped_lines(group, kWidth - 2 - indent.size()))
        out += fmt::format("{}# {}\n", indent, line);
    }
    out += commented(indent + last_part(key.name) + ": " + yaml_value(key), sentence(key));
  }
  return out;
}

std::string config_page() {
  const Defaults defaults;
  std::string out =
      "<!-- Written by tools/generate: do not edit here. -->\n"
      "# Configuration\n\n"
      "`cliquevod --config FILE` and the commands with `--config` read a YAML file with these sections; "
      "[`config/cliquevo.yaml`](../config/cliquevo.yaml) is one with every key at its default. Leave out what you do "
      "not change. `cliquevod --config FILE --check` validates a file and prints what is in force; for editors there "
      "is a JSON schema, [`config/cliquevo.schema.json`](../config/cliquevo.schema.json). Keys marked with * take "
      "effect on `systemctl reload cliquevod`; the others at the next start.\n";
  std::string section;
  for (const Key& key : defaults.table.keys()) {
    if (section_of(key) != section) {
      section = section_of(key);
      const auto row = std::find_if(defaults.table.sections().begin(), defaults.table.sections().end(),
                                    [&](const Section& s) { return s.name == section; });
      out += fmt::format("\n## {}\n\n{}.\n\n| key | default | unit and range | meaning |\n| --- | --- | --- | --- |\n",
                         section, row->meaning);
    }
    const std::string value = key.value();
    out += fmt::format("| `{}`{} | {} | {} | {} |\n", last_part(key.name), key.reloadable ? " *" : "",
                       value.empty() ? std::string("empty") : fmt::format("`{}`", value), limits(key), key.meaning);
  }
  return out;
}

std::string config_schema() {
  const Defaults defaults;
  ordered_json root;
  root["$schema"] = "http://json-schema.org/draft-07/schema#";
  root["title"] = "cliquevo configuration";
  root["type"] = "object";
  root["additionalProperties"] = false;
  const auto object_at = [&root](const std::string& name) -> ordered_json& {
    ordered_json* node = &root;
    std::size_t begin = 0;
    while (begin <= name.size()) {
      const std::size_t end = std::min(name.find('.', begin), name.size());
      node = &(*node)["properties"][name.substr(begin, end - begin)];
      begin = end + 1;
    }
    return *node;
  };
  for (const Section& section : defaults.table.sections()) {
    ordered_json& object = object_at(section.name);
    object["description"] = section.meaning;
    object["type"] = {"object", "null"};
    object["additionalProperties"] = false;
  }
  for (const Key& key : defaults.table.keys()) object_at(key.name) = schema_of(key);
  return root.dump(2) + "\n";
}

std::vector<std::string> config_settings() {
  const Defaults defaults;
  std::vector<std::string> out;
  for (const Key& key : defaults.table.keys()) {
    if (const Choice* choice = choice_of(key)) {
      for (const std::string& name : choice->names) out.push_back(key.name + "=" + name);
    } else if (std::holds_alternative<bool*>(key.field)) {
      out.push_back(key.name + "=true");
      out.push_back(key.name + "=false");
    } else {
      out.push_back(key.name + "=");
    }
  }
  return out;
}

std::string check_list() {
  ordered_json out = ordered_json::array();
  for (const vo::CheckRow& row : vo::kCheckRows) {
    out.push_back({{"number", static_cast<int>(row.check)},
                   {"symbol", row.symbol},
                   {"name", row.name},
                   {"verdict", vo::status_name(row.status)},
                   {"unit", row.unit},
                   {"meaning", row.meaning},
                   {"question", row.question},
                   {"value", row.value},
                   {"bound", row.bound}});
  }
  return out.dump(2) + "\n";
}

}  // namespace cliquevo::tools
