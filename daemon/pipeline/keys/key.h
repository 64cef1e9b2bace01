// SPDX-License-Identifier: BSD-3-Clause
// One key of the configuration: the place of its value, and everything that is known of it. Whatever reads, checks,
// lists or documents the configuration goes over a table of these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "core/base/result.h"

namespace cliquevo::daemon {

// Which numbers a key takes; of a text, how many characters.
struct Range {
  std::optional<double> low;
  std::optional<double> high;
  bool low_is_open = false;  // above `low`
  int multiple_of = 1;
  bool odd = false;

  bool contains(double value) const;
  // "5 to 21, odd", "0 or more", "above 0"; empty: any number.
  std::string text() const;
};
constexpr Range any() { return {}; }
constexpr Range between(double low, double high) { return {low, high}; }
constexpr Range at_least(double low) { return {low, std::nullopt}; }
constexpr Range above(double low) { return {low, std::nullopt, true}; }
constexpr Range odd_between(double low, double high) { return {low, high, false, 1, true}; }
constexpr Range multiple_between(int multiple, double low, double high) { return {low, high, false, multiple}; }

// One of a few names.
struct Choice {
  std::vector<std::string> names;
  std::function<std::size_t()> get;  // index of the name in force; names.size() = none of them
  std::function<void(std::size_t)> set;
};
struct FilePath {
  std::string* path = nullptr;  // relative ones start from the configuration file's folder
};
struct Triple {
  double* first = nullptr;  // of three in a row
};
using Field = std::variant<bool*, int*, std::int64_t*, std::uint64_t*, double*, std::optional<double>*, std::string*,
                           FilePath, Triple, Choice>;

struct Key {
  std::string name;  // as in the file, with dots
  Field field;
  std::string unit;  // empty = none
  Range range;
  std::string meaning;
  std::string group;        // heading under which it stands; empty = none
  bool reloadable = false;  // takes effect while the daemon runs

  // As the file has it.
  std::string value() const;
  // What kind of value it takes: "a whole number", "true or false", "one of a, b".
  std::string expects() const;
  // Takes over the value of the same key of another configuration.
  void copy_from(const Key& other) const;
  // Error: the value is out of its range. Its `where` is "key = value".
  Result<void> check() const;
};

// A section of the file: its keys begin with `name` and a dot.
struct Section {
  std::string name;
  std::string meaning;
};

// The table, bound to one configuration: values are read and written where that has them.
class KeyTable {
 public:
  const std::vector<Key>& keys() const { return keys_; }
  const std::vector<Section>& sections() const { return sections_; }

  // All that follows belongs to it.
  void section(const std::string& name, const std::string& meaning = "");
  void group(const std::string& heading) { group_ = heading; }
  Key& flag(const char* name, bool& value, const char* meaning);
  template <typename T>
  Key& number(const char* name, T& value, const char* unit, const Range& range, const char* meaning) {
    return add(name, &value, unit, range, meaning);
  }
  Key& triple(const char* name, Eigen::Vector3d& value, const char* unit, const Range& range, const char* meaning);
  Key& triple(const char* name, double (&value)[3], const char* unit, const Range& range, const char* meaning);
  // characters: how long it may be.
  Key& text(const char* name, std::string& value, const char* meaning, const Range& characters = any());
  Key& file(const char* name, std::string& value, const char* meaning);
  Key& choice(const char* name, std::string& value, std::vector<std::string> names, const char* meaning);
  template <typename T>
  Key& choice(const char* name, T& value, std::initializer_list<std::pair<const char*, T>> choices,
              const char* meaning) {
    Choice field;
    std::vector<T> values;
    for (const auto& [text, meant] : choices) {
      field.names.emplace_back(text);
      values.push_back(meant);
    }
    field.get = [&value, values] {
      std::size_t i = 0;
      while (i < values.size() && values[i] != value) ++i;
      return i;
    };
    field.set = [&value, values](std::size_t i) { value = values[i]; };
    return add(name, std::move(field), "", any(), meaning);
  }

 private:
  Key& add(const char* name, Field field, const char* unit, const Range& range, const char* meaning);

  std::vector<Section> sections_;
  std::vector<Key> keys_;
  std::string group_;
};

}  // namespace cliquevo::daemon
