// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/effective_config.h"

#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/printable.h"
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
    parts.push_back(path.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(path.substr(begin));
  return parts;
}

// In double quotes, with control characters as their numbers: what is printed is one line, and reads back.
std::string escaped(const std::string& value) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string out = "\"";
  for (std::size_t i = 0; i < value.size(); ++i) {
    auto byte = static_cast<unsigned char>(value[i]);
    const auto next = i + 1 < value.size() ? static_cast<unsigned char>(value[i + 1]) : 0U;
    const bool c1 = byte == 0xC2 && next >= 0x80 && next < 0xA0;  // two bytes of UTF-8
    if (c1) {
      byte = static_cast<unsigned char>(next);
      ++i;
    }
    if (c1 || byte < 0x20 || byte == 0x7F) {
      out += {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
    } else {
      if (byte == '"' || byte == '\\') out += '\\';
      out += static_cast<char>(byte);
    }
  }
  return out + "\"";
}

// Plain where YAML takes it as it stands, else in single quotes, where only they need care.
std::string scalar(const std::string& path, const std::string& value) {
  if (printable(value) != value) return escaped(value);
  if (path.ends_with("translation_m") || path.ends_with("_deg")) return value;  // numbers, also as lists
  const std::string safe = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-+/";
  const bool nothing = value == "null" || value == "Null" || value == "NULL";
  if (!value.empty() && !nothing && value.find_first_not_of(safe) == std::string::npos) return value;
  std::string out = "'";
  for (const char c : value) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

}  // namespace

std::string effective_config_yaml(const Config& config) {
  std::string out;
  std::vector<std::string> open;  // the sections that the last line stood in
  for (const auto& [path, value] : list_config(config)) {
    const std::vector<std::string> parts = split(path);
    std::size_t same = 0;
    while (same + 1 < parts.size() && same < open.size() && parts[same] == open[same]) ++same;
    open.assign(parts.begin(), parts.end() - 1);
    for (std::size_t depth = same; depth + 1 < parts.size(); ++depth) {
      out += std::string(2 * depth, ' ') + parts[depth] + ":\n";
    }
    out += std::string(2 * (parts.size() - 1), ' ') + parts.back() + ": " + scalar(path, value) + "\n";
  }
  return out;
}

std::string effective_config_json(const Config& config, const std::string& source) {
  Config listed = config;
  const KeyTable table = config_keys(listed);
  nlohmann::ordered_json out;
  for (const Key& key : table.keys()) {
    nlohmann::ordered_json* at = &out["configuration"];
    for (const std::string& part : split(key.name)) at = &(*at)[part];
    const std::string value = key.value();
    // Numbers, truth values and lists read as JSON; all else is text.
    const bool text = std::holds_alternative<std::string*>(key.field) || std::holds_alternative<FilePath>(key.field);
    auto read = nlohmann::ordered_json::parse(value, nullptr, false);
    *at = text || read.is_discarded() ? nlohmann::ordered_json(value) : std::move(read);
  }
  out["source"] = source;
  return out.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace cliquevo::daemon
