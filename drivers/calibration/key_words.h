// SPDX-License-Identifier: BSD-3-Clause
// A key of a calibration file as words, however they are joined.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

namespace cliquevo::drivers {

// Words in lower case: split at other characters, between small and capital letters, letters and digits.
std::vector<std::string> words_of(const std::string& key);

// Parts words to which one for the camera was written without anything between: "kl", "fxr", "mtxl", "leftcam".
void split_fused(std::vector<std::string>& words);

bool is_number(const std::string& word);
bool among(const std::string& word, std::initializer_list<const char*> words);

}  // namespace cliquevo::drivers
