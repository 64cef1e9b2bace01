// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/kernels/kernels.h"

#include "core/vo/kernels/tables.h"

namespace cliquevo::vo {

const Kernels* kernels_for(Isa isa) {
  if (!isa_available(isa)) return nullptr;
  switch (isa) {
#if defined(__x86_64__)
    case Isa::avx512:
      return &kAvx512Kernels;
    case Isa::avx2:
      return &kAvx2Kernels;
    case Isa::sse4:
      return &kSse4Kernels;
#elif defined(__aarch64__)
    case Isa::neon:
      return &kNeonKernels;
#endif
    default:
      return &kReferenceKernels;
  }
}

const Kernels& kernels() {
  static const Kernels* const table = kernels_for(active_isa());
  return table != nullptr ? *table : kReferenceKernels;
}

}  // namespace cliquevo::vo
