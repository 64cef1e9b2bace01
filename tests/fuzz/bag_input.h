// SPDX-License-Identifier: BSD-3-Clause
// What the fuzzers of all bags share.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cliquevo::fuzz {

void play_bag(const std::uint8_t* data, std::size_t size);

}  // namespace cliquevo::fuzz
