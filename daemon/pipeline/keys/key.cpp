// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/keys/key.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace cliquevo::daemon {

namespace {

constexpr const char* kAutomatic = "auto";  // how the file leaves an optional value open

template <typename... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <typename... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

// The numbers that a range is about: the value, its three parts, or how many characters it has.
std::vector<double> measured(const Field& field) {
  return std::visit(
      Overloaded{
          [](const bool*) { return std::vector<double>{}; },
          [](const std::string* v) { return std::vector<double>{static_cast<double>(v->size())}; },
          [](const std::optional<double>* v) { return *v ? std::vector<double>{**v} : std::vector<double>{}; },
          [](const FilePath&) { return std::vector<double>{}; },
          [](const Triple& v) { return std::vector<double>(v.first, v.first + 3); },
          [](const Choice&) { return std::vector<double>{}; },
          [](const auto* v) { return std::vector<double>{static_cast<double>(*v)}; },
      },
      field);
}

}  // namespace

bool Range::contains(double value) const {
  if (low && (low_is_open ? !(value > *low) : !(value >= *low))) return false;
  if (high && !(value <= *high)) return false;
  if (odd && std::fmod(value, 2.0) == 0.0) return false;
  return multiple_of == 1 || std::fmod(value, multiple_of) == 0.0;
}

std::string Range::text() const {
  std::string out;
  if (low && high) {
    out = fmt::format("{} to {}", *low, *high);
  } else if (low) {
    out = low_is_open ? fmt::format("above {}", *low) : fmt::format("{} or more", *low);
  } else if (high) {
    out = fmt::format("{} or less", *high);
  }
  if (odd) out += ", odd";
  if (multiple_of != 1) out += fmt::format(", a multiple of {}", multiple_of);
  return out;
}

std::string Key::value() const {
  return std::visit(
      Overloaded{
          [](const bool* v) -> std::string { return *v ? "true" : "false"; },
          [](const std::string* v) { return *v; },
          [](const std::optional<double>* v) { return *v ? fmt::format("{}", **v) : std::string(kAutomatic); },
          [](const FilePath& v) { return *v.path; },
          [](const Triple& v) { return fmt::format("[{}, {}, {}]", v.first[0], v.first[1], v.first[2]); },
          [](const Choice& v) {
            const std::size_t i = v.get();
            return i < v.names.size() ? v.names[i] : std::string();
          },
          [](const auto* v) { return fmt::format("{}", *v); },
      },
      field);
}

std::string Key::expects() const {
  return std::visit(Overloaded{
                        [](const bool*) -> std::string { return "true or false"; },
                        [](const std::string*) -> std::string { return "a text"; },
                        [](const double*) -> std::string { return "a number"; },
                        [](const std::optional<double>*) { return fmt::format("a number or {}", kAutomatic); },
                        [](const std::uint64_t*) -> std::string { return "a whole number, not negative"; },
                        [](const FilePath&) -> std::string { return "a text"; },
                        [](const Triple&) -> std::string { return "three numbers, [a, b, c]"; },
                        [](const Choice& v) { return fmt::format("one of {}", fmt::join(v.names, ", ")); },
                        [](const auto*) -> std::string { return "a whole number"; },
                    },
                    field);
}

void Key::copy_from(const Key& other) const {
  std::visit(
      [&other](const auto& to) {
        using T = std::decay_t<decltype(to)>;
        const T* from = std::get_if<T>(&other.field);
        if (from == nullptr) return;
        if constexpr (std::is_same_v<T, Choice>) {
          to.set(from->get());
        } else if constexpr (std::is_same_v<T, FilePath>) {
          *to.path = *from->path;
        } else if constexpr (std::is_same_v<T, Triple>) {
          std::copy(from->first, from->first + 3, to.first);
        } else {
          *to = **from;
        }
      },
      field);
}

Result<void> Key::check() const {
  const bool is_text = std::holds_alternative<std::string*>(field);
  for (const double number : measured(field)) {
    if (range.contains(number)) continue;
    const bool in_bounds = Range{range.low, range.high, range.low_is_open}.contains(number);
    std::string remedy = "give " + range.text();
    if (is_text && range.low.value_or(0.0) > 0.0) {
      remedy = fmt::format("give a name of {} to {} characters", *range.low, *range.high);
    } else if (is_text) {
      remedy = fmt::format("give a name of {} characters at most, or none", *range.high);
    } else if (in_bounds && range.odd) {
      remedy = fmt::format("give an odd number from {} to {}", *range.low, *range.high);
    } else if (in_bounds) {
      remedy = fmt::format("give a multiple of {}", range.multiple_of);
    }
    return Error{"configuration value out of range", fmt::format("{} = {}", name, value()), remedy};
  }
  return {};
}

void KeyTable::section(const std::string& name, const std::string& meaning) {
  sections_.push_back({name, meaning});
  group_.clear();
}

Key& KeyTable::add(const char* name, Field field, const char* unit, const Range& range, const char* meaning) {
  keys_.push_back({sections_.back().name + "." + name, std::move(field), unit, range, meaning, group_});
  return keys_.back();
}

Key& KeyTable::flag(const char* name, bool& value, const char* meaning) {
  return add(name, &value, "", any(), meaning);
}

Key& KeyTable::triple(const char* name, Eigen::Vector3d& value, const char* unit, const Range& range,
                      const char* meaning) {
  return add(name, Triple{value.data()}, unit, range, meaning);
}

Key& KeyTable::triple(const char* name, double (&value)[3], const char* unit, const Range& range, const char* meaning) {
  return add(name, Triple{value}, unit, range, meaning);
}

Key& KeyTable::text(const char* name, std::string& value, const char* meaning, const Range& characters) {
  return add(name, &value, "", characters, meaning);
}

Key& KeyTable::file(const char* name, std::string& value, const char* meaning) {
  return add(name, FilePath{&value}, "", any(), meaning);
}

Key& KeyTable::choice(const char* name, std::string& value, std::vector<std::string> names, const char* meaning) {
  Choice field;
  field.names = names;
  field.get = [&value, names] {
    std::size_t i = 0;
    while (i < names.size() && names[i] != value) ++i;
    return i;
  };
  field.set = [&value, names = std::move(names)](std::size_t i) { value = names[i]; };
  return add(name, std::move(field), "", any(), meaning);
}

}  // namespace cliquevo::daemon
