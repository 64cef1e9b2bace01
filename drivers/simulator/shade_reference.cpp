// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/isa.h"
#include "drivers/simulator/shade_kernel.inl"

namespace cliquevo::drivers::sim {

const ShadeKernels& shade_kernels_reference() {
  static constexpr ShadeKernels kernels{&ground, &sky};
  return kernels;
}

const ShadeKernels& shade_kernels() {
#ifdef CLIQUEVO_SIMULATOR_AVX2
  if (active_isa() == Isa::avx2 || active_isa() == Isa::avx512) return shade_kernels_avx2();
#endif
  return shade_kernels_reference();
}

}  // namespace cliquevo::drivers::sim
