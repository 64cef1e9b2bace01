// SPDX-License-Identifier: BSD-3-Clause
// Which instruction set the SIMD kernels of every room run on.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cliquevo {

// Instruction sets that kernels are written for. Worst first: a set takes over the kernels of the one before it
// (kernel_tables.h). neon stands last because no machine has it beside the others. A set more: before
// `count`, and its row in isa.cpp.
enum class Isa { reference, sse4, avx2, avx512, neon, count };

// The best this machine has, or what the environment variable CLIQUEVO_ISA (reference, sse4, avx2, avx512, neon)
// forces. A name that is unknown, or that of a set that the machine lacks, is reported on stderr and gives the
// reference. Decided once a process.
Isa active_isa();
// Whether the machine runs it (reference: always).
bool isa_available(Isa isa);
// "avx2"
const char* isa_name(Isa isa);
// The set of that name; nothing: there is none.
std::optional<Isa> isa_by_name(std::string_view name);
// All sets, worst first, whether the machine runs them or not.
std::vector<Isa> isas();

// What active_isa() decides from.
struct IsaChoice {
  Isa isa = Isa::reference;  // one that this machine runs
  std::string complaint;     // one line: what, where, what to do; empty: none
};
// forced: what CLIQUEVO_ISA holds; empty or nullptr: nothing is forced.
IsaChoice choose_isa(const char* forced);

}  // namespace cliquevo
