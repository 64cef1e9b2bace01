// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

extern const Kernels kReferenceKernels;
#if defined(__x86_64__)
extern const Kernels kSse4Kernels;
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;
#elif defined(__aarch64__)
extern const Kernels kNeonKernels;
#endif

}  // namespace cliquevo::vo
