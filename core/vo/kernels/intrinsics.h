// SPDX-License-Identifier: BSD-3-Clause
// The processor's own operations, where it has any that the kernels use.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif
