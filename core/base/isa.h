// SPDX-License-Identifier: BSD-3-Clause
// Which instruction set the SIMD kernels of every room run on.
#pragma once

namespace cliquevo {

// Instruction sets that kernels are written for.
enum class Isa { reference, sse4, avx2, neon, avx512 };

// The best this machine has, or what the environment variable CLIQUEVO_ISA (reference, sse4, avx2, avx512, neon)
// forces; a forced one that the machine lacks falls back to the reference. Decided once a process.
Isa active_isa();
// Whether the machine runs it (reference: always).
bool isa_available(Isa isa);
// "avx2"
const char* isa_name(Isa isa);

}  // namespace cliquevo
