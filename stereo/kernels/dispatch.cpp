// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

const KernelTables<Table>& tables() {
  static const KernelTables<Table> all(kReference, {
#if defined(__x86_64__)
    {Isa::sse4, use_sse4}, {Isa::avx2, use_avx2}, {Isa::avx512, use_avx512},
#elif defined(__aarch64__)
                                                       {Isa::neon, use_neon},
#endif
  });
  return all;
}

const Table& active() { return tables().active(); }

}  // namespace cliquevo::stereo::kernels
