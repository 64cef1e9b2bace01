// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/shade_kernel.inl"

namespace cliquevo::drivers::sim {

const KernelTables<ShadeKernels>& shade_tables() {
  static const KernelTables<ShadeKernels> all({.ground = ground, .sky = sky}, {
#ifdef CLIQUEVO_SIMULATOR_AVX2
                                                                                  {Isa::avx2, use_avx2},
#endif
                                                                              });
  return all;
}

}  // namespace cliquevo::drivers::sim
