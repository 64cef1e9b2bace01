// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/key_words.h"

#include <algorithm>
#include <cctype>

namespace cliquevo::drivers {

namespace {

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

// What a word for the camera is written to without anything between.
bool is_stem(const std::string& w) {
  return among(w, {"k",      "m",     "d",          "p",          "r",    "a",  "kk",  "cm",       "fx",
                   "fy",     "cx",    "cy",         "mtx",        "dist", "kc", "cam", "camera",   "matrix",
                   "coeffs", "coeff", "intrinsics", "distortion", "xi",   "t",  "mat", "intrinsic"});
}

// The words that one stands for: "kl", "fxr", "mtxl", "leftcam", "rk", "rstereo"; none = itself.
std::vector<std::string> parts_of(const std::string& w) {
  if (among(w, {"tlr", "trl", "rlr", "rrl"})) return {w.substr(0, 1), "lr"};
  if (among(w, {"rstereo", "tstereo"})) return {w.substr(0, 1), "stereo"};
  if (among(w, {"lk", "ld", "lmtx", "ldist", "rk", "rd", "rmtx", "rdist"})) return {w.substr(1), w.substr(0, 1)};
  for (const std::string side : {"left", "right"}) {
    if (w.size() <= side.size()) continue;
    if (w.starts_with(side) && is_stem(w.substr(side.size()))) return {w.substr(side.size()), side};
    if (w.ends_with(side) && is_stem(w.substr(0, w.size() - side.size()))) {
      return {w.substr(0, w.size() - side.size()), side};
    }
  }
  if (w.size() < 2 || (w.back() != 'l' && w.back() != 'r')) return {};
  const std::string stem = w.substr(0, w.size() - 1);
  if (!is_stem(stem) || among(stem, {"t", "mat", "camera", "intrinsic"})) return {};
  return {stem, w.substr(w.size() - 1)};
}

}  // namespace

bool among(const std::string& word, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return word == w; });
}

bool is_number(const std::string& word) { return !word.empty() && is_digit(word[0]); }

std::vector<std::string> words_of(const std::string& key) {
  std::vector<std::string> out;
  bool open = false;
  for (std::size_t i = 0; i < key.size(); ++i) {
    const char c = key[i];
    if (!is_letter(c) && !is_digit(c)) {
      open = false;
      continue;
    }
    if (open) {
      const char before = key[i - 1];
      const bool next_small = i + 1 < key.size() && is_letter(key[i + 1]) && !is_upper(key[i + 1]);
      const bool cut = is_digit(c) != is_digit(before) || (is_upper(c) && !is_upper(before)) ||
                       (is_upper(c) && is_upper(before) && next_small);
      open = !cut;
    }
    if (!open) out.emplace_back();
    open = true;
    out.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

void split_fused(std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto at = words.begin() + static_cast<std::ptrdiff_t>(i);
    if (among(words[i], {"u", "v"}) && i + 1 < words.size() && words[i + 1] == "0") {  // "u0" is of no camera 0
      words[i] += "0";
      words.erase(at + 1);
      continue;
    }
    const std::vector<std::string> parts = parts_of(words[i]);
    if (parts.empty()) continue;
    words[i] = parts[0];
    words.insert(at + 1, parts[1]);
    ++i;
  }
}

}  // namespace cliquevo::drivers
