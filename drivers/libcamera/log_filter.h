// SPDX-License-Identifier: BSD-3-Clause
// What libcamera writes to stderr of its own accord: its errors, and not its greetings.
#pragma once

namespace cliquevo::drivers {

// Call before the first use of libcamera. Does nothing where LIBCAMERA_LOG_LEVELS or LIBCAMERA_LOG_FILE requests more.
void show_only_errors_of_libcamera();

}  // namespace cliquevo::drivers
