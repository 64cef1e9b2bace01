// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/keys/key_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <type_traits>

namespace cliquevo::daemon {

namespace {

namespace fs = std::filesystem;

template <typename T>
bool read_number(const YAML::Node& node, T& value) {
  if (!node.IsScalar()) return false;
  const std::string& text = node.Scalar();
  T number{};
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const auto [end, failed] = std::from_chars(begin, text.data() + text.size(), number);
  if (failed != std::errc{} || end != text.data() + text.size()) return false;
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(number)) return false;
  }
  value = number;
  return true;
}

bool read(const YAML::Node& node, std::string& value) {
  if (!node.IsScalar() && !node.IsNull()) return false;
  value = node.IsNull() ? "" : node.Scalar();
  return true;
}

// Reads a node into whatever field the key has.
struct Reader {
  const YAML::Node& node;
  const std::string& folder;

  bool operator()(bool* value) const {
    if (!node.IsScalar() || (node.Scalar() != "true" && node.Scalar() != "false")) return false;
    *value = node.Scalar() == "true";
    return true;
  }
  bool operator()(std::optional<double>* value) const {
    if (node.IsScalar() && node.Scalar() == "auto") {
      value->reset();
      return true;
    }
    double number = 0.0;
    if (!read_number(node, number)) return false;
    *value = number;
    return true;
  }
  bool operator()(std::string* value) const { return read(node, *value); }
  bool operator()(const FilePath& field) const {
    if (!read(node, *field.path)) return false;
    if (!field.path->empty() && fs::path(*field.path).is_relative()) {
      *field.path = (fs::path(folder) / *field.path).lexically_normal().string();
    }
    return true;
  }
  bool operator()(const Triple& field) const {
    double numbers[3];
    if (!node.IsSequence() || node.size() != 3) return false;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!read_number(node[i], numbers[i])) return false;
    }
    std::copy(std::begin(numbers), std::end(numbers), field.first);
    return true;
  }
  bool operator()(const Choice& field) const {
    if (!node.IsScalar()) return false;
    const auto found = std::find(field.names.begin(), field.names.end(), node.Scalar());
    if (found == field.names.end()) return false;
    field.set(static_cast<std::size_t>(found - field.names.begin()));
    return true;
  }
  template <typename T>
  bool operator()(T* value) const {
    return read_number(node, *value);
  }
};

}  // namespace

bool read_value(const Key& key, const YAML::Node& node, const std::string& folder) {
  return std::visit(Reader{node, folder}, key.field);
}

}  // namespace cliquevo::daemon
