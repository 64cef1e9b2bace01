// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/isa.h"

#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace cliquevo {

bool isa_available(Isa isa) {
  switch (isa) {
    case Isa::reference:
      return true;
#if defined(__x86_64__)
    case Isa::sse4:
      return __builtin_cpu_supports("sse4.1") != 0 && __builtin_cpu_supports("ssse3") != 0;
    case Isa::avx2:
      return __builtin_cpu_supports("avx2") != 0;
    case Isa::avx512:  // with byte and word operations
      return __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0;
    case Isa::neon:
      return false;
#elif defined(__aarch64__)
    case Isa::neon:
      return true;
    default:
      return false;
#else
    default:
      return false;
#endif
  }
  return false;
}

const char* isa_name(Isa isa) {
  switch (isa) {
    case Isa::sse4:
      return "sse4";
    case Isa::avx2:
      return "avx2";
    case Isa::avx512:
      return "avx512";
    case Isa::neon:
      return "neon";
    case Isa::reference:
      break;
  }
  return "reference";
}

Isa active_isa() {
  static const Isa chosen = [] {
    const char* forced = std::getenv("CLIQUEVO_ISA");
    for (const Isa isa : {Isa::avx512, Isa::avx2, Isa::neon, Isa::sse4, Isa::reference}) {
      if (forced != nullptr && *forced != '\0') {
        if (std::strcmp(forced, isa_name(isa)) == 0) return isa_available(isa) ? isa : Isa::reference;
      } else if (isa_available(isa)) {
        return isa;
      }
    }
    return Isa::reference;
  }();
  return chosen;
}

}  // namespace cliquevo
