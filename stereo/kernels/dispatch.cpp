// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

#if defined(__x86_64__)
namespace {

// The row kernels are short of memory, not of width. Put together here, not in a file whose code this machine may lack.
const Table& avx512_table() {
  static const Table table = [] {
    Table t = kAvx2;
    t.isa = Isa::avx512;
    t.match_row = match_row_avx512;
    return t;
  }();
  return table;
}

}  // namespace
#endif

const Table& table(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::sse4:
      return kSse4;
    case Isa::avx2:
      return kAvx2;
    case Isa::avx512:
      return avx512_table();
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
