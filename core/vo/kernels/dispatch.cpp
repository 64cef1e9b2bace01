// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

const KernelTables<Kernels>& kernel_tables() {
  static const KernelTables<Kernels> all(kReferenceKernels, {
#if defined(__x86_64__)
    {Isa::sse4, use_sse4}, {Isa::avx2, use_avx2}, {Isa::avx512, use_avx512},
#elif defined(__aarch64__)
    {Isa::neon, use_neon},
#endif
  });
  return all;
}

const Kernels& kernels() {
  static const Kernels& active = kernel_tables().active();
  return active;
}

}  // namespace cliquevo::vo
