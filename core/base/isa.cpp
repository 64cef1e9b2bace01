// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/isa.h"

#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include "core/base/printable.h"
#include "core/base/result.h"

namespace cliquevo {

namespace {

#if defined(__x86_64__)
constexpr bool kArm64 = false;
bool has_sse4() { return __builtin_cpu_supports("sse4.1") != 0 && __builtin_cpu_supports("ssse3") != 0; }
bool has_avx2() { return __builtin_cpu_supports("avx2") != 0; }
// With byte and word operations.
bool has_avx512() { return __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0; }
#else
#if defined(__aarch64__)
constexpr bool kArm64 = true;
#else
constexpr bool kArm64 = false;
#endif
bool has_sse4() { return false; }
bool has_avx2() { return false; }
bool has_avx512() { return false; }
#endif

struct Row {
  Isa isa;
  const char* name;
  bool (*available)();
};

// Lowest first; the only list of the sets.
constexpr Row kRows[] = {
    {Isa::reference, "reference", [] { return true; }},
    {Isa::sse4, "sse4", has_sse4},
    {Isa::avx2, "avx2", has_avx2},
    {Isa::avx512, "avx512", has_avx512},
    {Isa::neon, "neon", [] { return kArm64; }},
};

constexpr bool is_complete() {
  std::size_t place = 0;
  for (const Row& row : kRows) {
    if (static_cast<std::size_t>(row.isa) != place++) return false;
  }
  return place == static_cast<std::size_t>(Isa::count);
}
static_assert(is_complete(), "a row for each Isa, in the order of isa.h");

std::string names() {
  std::string out;
  for (const Row& row : kRows) out += (out.empty() ? "" : ", ") + std::string(row.name);
  return out;
}

}  // namespace

bool isa_available(Isa isa) { return kRows[static_cast<std::size_t>(isa)].available(); }

const char* isa_name(Isa isa) { return kRows[static_cast<std::size_t>(isa)].name; }

std::optional<Isa> isa_by_name(std::string_view name) {
  for (const Row& row : kRows) {
    if (name == row.name) return row.isa;
  }
  return std::nullopt;
}

std::vector<Isa> isas() {
  std::vector<Isa> out;
  for (const Row& row : kRows) out.push_back(row.isa);
  return out;
}

IsaChoice choose_isa(const char* forced) {
  if (forced == nullptr || *forced == '\0') {
    IsaChoice best;
    for (const Row& row : kRows) {
      if (row.available()) best.isa = row.isa;
    }
    return best;
  }
  const std::string where = "CLIQUEVO_ISA=" + printable(std::string_view(forced));
  const std::optional<Isa> named = isa_by_name(forced);
  if (!named) {
    return {Isa::reference,
            Error{"unknown instruction set", where, "the reference runs instead; known are " + names()}.line()};
  }
  if (!isa_available(*named)) {
    return {Isa::reference, Error{"this machine lacks the instruction set", where,
                                  "the reference runs instead; unset it for the best that there is"}
                                .line()};
  }
  return {*named, {}};
}

Isa active_isa() {
  static const Isa chosen = [] {
    const IsaChoice choice = choose_isa(std::getenv("CLIQUEVO_ISA"));
    if (!choice.complaint.empty()) std::fprintf(stderr, "%s\n", choice.complaint.c_str());
    return choice.isa;
  }();
  return chosen;
}

}  // namespace cliquevo
