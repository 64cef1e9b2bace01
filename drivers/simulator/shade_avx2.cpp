// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/shade_kernel.inl"

namespace cliquevo::drivers::sim {

const ShadeKernels& shade_kernels_avx2() {
  static constexpr ShadeKernels kernels{&ground, &sky};
  return kernels;
}

}  // namespace cliquevo::drivers::sim
