// SPDX-License-Identifier: BSD-3-Clause
// SHA-256, and what the keys of units are made of by it.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace cliquevo::tools::fleet {

class Digest {
 public:
  Digest();
  ~Digest();
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  Digest& add(std::string_view bytes);
  // "name=value" and the value's length: no two lists of fields give the same bytes.
  Digest& field(std::string_view name, std::string_view value);
  // 64 lower-case hexadecimal digits; nothing may be added after it.
  std::string hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string sha256(std::string_view bytes);

// What decides the numbers that this program computes: the build of the program and of every library loaded into it,
// by their build ids, and the module for videos where it is installed. Equal on two machines when they run the same
// packages; computed once, before anything else is loaded.
const std::string& build_digest();

}  // namespace cliquevo::tools::fleet
