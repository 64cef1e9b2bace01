// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

const Table& table(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::sse4:
      return kSse4;
    case Isa::avx2:
      return kAvx2;
    case Isa::avx512:
      return kAvx512;
#elif defined(__aarch64__)
    case Isa::neon:
      return kNeon;
#endif
    default:
      return kReference;
  }
}

const Table& active() { return table(active_isa()); }

}  // namespace cliquevo::stereo::kernels
