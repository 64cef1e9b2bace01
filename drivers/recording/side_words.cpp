// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/side_words.h"

#include <algorithm>
#include <array>
#include <utility>

#include "drivers/recording/letters.h"

namespace cliquevo::drivers {

namespace {

constexpr char kMark = '\x01';  // stands for the word that was taken out; no file name holds it

struct WordPair {
  const char* left;
  const char* right;
  int kind;
};
constexpr std::array<WordPair, 10> kWords{{{"left", "right", kWordKind},
                                           {"l", "r", kLetterKind},
                                           {"links", "rechts", kFirstOtherKind},
                                           {"gauche", "droite", kFirstOtherKind + 1},
                                           {"izquierda", "derecha", kFirstOtherKind + 2},
                                           {"cam_b", "cam_c", kFirstOtherKind + 3},  // DepthAI's sockets
                                           {"camb", "camc", kFirstOtherKind + 3},
                                           {"cam_a", "cam_b", kFirstOtherKind + 4},
                                           {"cama", "camb", kFirstOtherKind + 4},
                                           {"lcam", "rcam", kFirstOtherKind + 5}}};  // TartanAir V2

// A single letter that is a word of its own: between separators, digits or changes of case.
bool stands_alone(const std::string& name, std::size_t at) {
  const char c = name[at];
  if (at > 0 && is_letter(name[at - 1]) && !(is_upper(c) && is_lower(name[at - 1]))) return false;
  if (at + 1 >= name.size() || !is_letter(name[at + 1])) return true;
  if (is_lower(c)) return is_upper(name[at + 1]);                                   // "lImage"
  return is_upper(name[at + 1]) && at + 2 < name.size() && is_lower(name[at + 2]);  // "LImage"
}

void add_words(const std::string& name, const std::string& low, std::vector<SideReading>& out) {
  for (const WordPair& words : kWords) {
    for (const auto& [word, side] : {std::pair{words.left, Side::left}, std::pair{words.right, Side::right}}) {
      const std::string text(word);
      for (std::size_t at = low.find(text); at != std::string::npos; at = low.find(text, at + 1)) {
        if (text.size() == 1 && !stands_alone(name, at)) continue;
        std::string rest = low;
        out.push_back({words.kind, side, rest.replace(at, text.size(), 1, kMark)});
      }
    }
  }
}

// Whether what stands beside a number is a word for cameras and their pictures, or a single letter: "run1" and "run2"
// are no pair. A name that is nothing but a number is left to its neighbours.
bool names_a_camera(const std::string& low, std::size_t begin, std::size_t end) {
  static constexpr std::array<const char*, 16> kParts{"cam",   "image", "img",  "view", "eye", "sensor",
                                                      "lens",  "mono",  "gray", "grey", "rgb", "colo",
                                                      "video", "rect",  "fish", "infra"};
  static constexpr std::array<const char*, 3> kWhole{"im", "ir", "ch"};
  const auto is_separator = [](char c) { return c == '_' || c == '-' || c == '.' || c == ' '; };
  std::size_t last = begin;
  while (last > 0 && is_separator(low[last - 1])) --last;
  std::size_t first = last;
  while (first > 0 && is_letter(low[first - 1])) --first;
  std::string word = low.substr(first, last - first);
  if (word.empty()) {
    if (begin == 0 && end == low.size()) return true;
    if (begin != 0) return false;
    std::size_t from = end;
    while (from < low.size() && is_separator(low[from])) ++from;
    std::size_t to = from;
    while (to < low.size() && is_letter(low[to])) ++to;
    word = low.substr(from, to - from);
  }
  const auto is_part = [&](const char* known) { return word.find(known) != std::string::npos; };
  return word.size() == 1 || std::find(kWhole.begin(), kWhole.end(), word) != kWhole.end() ||
         std::any_of(kParts.begin(), kParts.end(), is_part);
}

// A number is the left one of its pair, or the right one: its partner decides. "02" and "03" keep their zeros.
void add_numbers(const std::string& low, std::vector<SideReading>& out) {
  for (std::size_t at = 0; at < low.size();) {
    std::size_t end = at;
    while (end < low.size() && is_digit(low[end])) ++end;
    if (end == at) {
      ++at;
      continue;
    }
    const std::size_t digits = end - at;
    if (digits <= 2 && names_a_camera(low, at, end)) {
      const int value = std::stoi(low.substr(at, digits));
      std::string rest = low;
      rest.replace(at, digits, digits, kMark);
      if (value < 99 && !(digits == 1 && value == 9)) out.push_back({kFirstNumberKind + value, Side::left, rest});
      if (value > 0) out.push_back({kFirstNumberKind + value - 1, Side::right, rest});
    }
    at = end;
  }
}

}  // namespace

std::vector<SideReading> read_sides(const std::string& name) {
  std::vector<SideReading> out;
  const std::string low = lower(name);
  add_words(name, low, out);
  add_numbers(low, out);
  std::stable_sort(out.begin(), out.end(), [](const SideReading& a, const SideReading& b) { return a.kind < b.kind; });
  return out;
}

std::optional<int> pair_kind(const std::string& left, const std::string& right) {
  const std::vector<SideReading> of_right = read_sides(right);
  for (const SideReading& l : read_sides(left)) {
    if (l.side != Side::left) continue;
    for (const SideReading& r : of_right) {
      if (r.side == Side::right && r.kind == l.kind && r.rest == l.rest) return l.kind;
    }
  }
  return std::nullopt;
}

bool differ_in_a_number(const std::string& left, const std::string& right) {
  const auto is_number = [](const SideReading& r) { return r.kind >= kFirstNumberKind && r.kind < kFirstOtherKind; };
  const std::vector<SideReading> of_right = read_sides(right);
  for (const SideReading& l : read_sides(left)) {
    if (l.side != Side::left || !is_number(l)) continue;
    for (const SideReading& r : of_right) {
      if (r.side == Side::right && is_number(r) && r.kind >= l.kind && r.rest == l.rest) return true;
    }
  }
  return false;
}

std::optional<std::string> without_side(const std::string& name, int kind, Side side) {
  for (const SideReading& reading : read_sides(name)) {
    if (reading.kind != kind || reading.side != side) continue;
    // The separators that stood on both sides of the word become one: "img_0001_left" and "left_img_0001" end plainly.
    const auto is_separator = [](char c) { return c == '_' || c == '-' || c == '.' || c == ' '; };
    const std::size_t first = reading.rest.find(kMark);
    const std::size_t last = reading.rest.rfind(kMark);
    std::string before = reading.rest.substr(0, first);
    std::string after = reading.rest.substr(last + 1);
    while (!before.empty() && is_separator(before.back()) && (after.empty() || is_separator(after.front()))) {
      before.pop_back();
    }
    while (before.empty() && !after.empty() && is_separator(after.front())) after.erase(0, 1);
    return before + after;
  }
  return std::nullopt;
}

std::string kind_name(int kind) {
  if (kind == kWordKind) return "left and right";
  if (kind == kLetterKind) return "l and r";
  for (const WordPair& words : kWords) {
    if (words.kind == kind) return std::string(words.left) + " and " + words.right;
  }
  const int low = kind - kFirstNumberKind;
  return std::to_string(low) + " and " + std::to_string(low + 1);
}

}  // namespace cliquevo::drivers
