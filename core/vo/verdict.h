// SPDX-License-Identifier: BSD-3-Clause
// From the checks to the verdict: the only place where a status is decided.
#pragma once

#include "core/vo/evidence.h"

namespace cliquevo::vo {

// "too few features"
const char* status_name(Status status);

// That of the first check that fails, in the order of the table; valid where none does.
Status verdict(const Checks& checks);

}  // namespace cliquevo::vo
