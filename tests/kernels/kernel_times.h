// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cliquevo::stereo::kernels {

// A table of cycles a pixel: kernels by instruction sets.
void print_kernel_times();

}  // namespace cliquevo::stereo::kernels
