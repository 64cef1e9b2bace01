// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/shade_kernel.inl"

namespace cliquevo::drivers::sim {

void use_avx2(ShadeKernels& kernels) {
  kernels.ground = ground;
  kernels.sky = sky;
}

}  // namespace cliquevo::drivers::sim
