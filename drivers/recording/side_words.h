// SPDX-License-Identifier: BSD-3-Clause
// How names mark left and right: by a word (left/right, l/r) or a number (0/1, 1/2, 2/3, ...), anywhere in the name.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cliquevo::drivers {

enum class Side { left, right };

// One way to read a name as that of a side.
struct SideReading {
  int kind = 0;  // which mark: kWordKind, kLetterKind, or kFirstNumberKind + the left side's number
  Side side = Side::left;
  std::string rest;  // lower case, with a mark where the word for the side was
};

// From the clearest to the weakest.
inline constexpr int kWordKind = 0;
inline constexpr int kLetterKind = 1;
inline constexpr int kFirstNumberKind = 2;
inline constexpr int kFirstOtherKind = 200;  // words of other languages, and other makers' names

// Every reading there is; none for a name without a side. Words are found anywhere ("imageLeft"), letters where
// they stand alone ("cam_l", "imgL"), numbers of one or two digits ("cam0", "I1_000007", "image_02").
std::vector<SideReading> read_sides(const std::string& name);

// The readings under which two names are those of a left and a right image: same kind, same rest.
std::optional<int> pair_kind(const std::string& left, const std::string& right);

// Names of cameras with a number each, whatever lies between them ("video0", "video2"), the lower one first.
bool differ_in_a_number(const std::string& left, const std::string& right);

// The name without the word for its side, as `kind` has it: what both images of a pair share; empty = it has no such
// word.
std::optional<std::string> without_side(const std::string& name, int kind, Side side);

// What a kind is called in messages: "left and right", "0 and 1".
std::string kind_name(int kind);

}  // namespace cliquevo::drivers
