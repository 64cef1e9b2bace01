// SPDX-License-Identifier: BSD-3-Clause
// One input to the parsers of calibrations and times, and what must hold of the outcome whatever the input.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cliquevo::fuzz {

// The first byte chooses the parser (by the name the file would have), the rest is the file. Returns what is wrong with
// the outcome; empty = an error that is one clear line, or a result that is finite and sane.
std::string parse_anything(const std::uint8_t* data, std::size_t size);

// The number of parsers to choose from.
int parser_count();
// A mutation of `text` that depends on the state alone; the state moves on.
std::string mutated(std::string text, std::uint64_t& state);

}  // namespace cliquevo::fuzz
