// SPDX-License-Identifier: BSD-3-Clause
// stdin, stdout and stderr as they are found: closed, full, or a pipe that nobody reads any more.
#pragma once

#include <string>

#include "core/base/result.h"

namespace cliquevo {

// First thing in a program. A standard stream that is closed is opened on nothing, so that no file opened later gets
// its number, and with it the program's messages; writing to such a stdout still fails. A pipe without a reader is an
// error of the write, not the end of the program.
void keep_standard_streams();
// Whatever was printed has reached stdout; else the error to report. Last thing in a program.
Result<void> flush_stdout();
// A line on stderr, made printable. Never throws; nothing is done about a stderr that takes nothing.
void print_error_line(const std::string& line) noexcept;

}  // namespace cliquevo
