// SPDX-License-Identifier: BSD-3-Clause
#include <smmintrin.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"
#include "stereo/kernels/rows.h"
#include "stereo/kernels/sse4_ops.h"

void match_row(const MatchJob& job) { match_row_with<Sse4>(job); }

}  // namespace

void use_sse4(Table& table) {
  use_rows<Sse4, Sse4>(table);
  table.match_row = match_row;
}

}  // namespace cliquevo::stereo::kernels
