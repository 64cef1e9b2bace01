// SPDX-License-Identifier: BSD-3-Clause
// Standard streams that are closed or full; each in a process of its own, whose streams may be spoilt.
#include "core/base/standard_streams.h"

#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <unistd.h>

#include <gtest/gtest.h>

namespace cliquevo {
namespace {

using testing::ExitedWithCode;

TEST(StandardStreams, AClosedOneIsTakenSoThatNoFileGetsItsNumber) {
  EXPECT_EXIT(
      {
        ::close(STDIN_FILENO);
        ::close(STDOUT_FILENO);
        keep_standard_streams();
        const int next = ::open("/dev/null", O_RDONLY);
        std::_Exit(next > STDERR_FILENO && ::write(STDOUT_FILENO, "x", 1) < 0 ? 7 : 1);
      },
      ExitedWithCode(7), "");
}

TEST(StandardStreams, APipeWithoutAReaderIsAnErrorOfTheWrite) {
  EXPECT_EXIT(
      {
        keep_standard_streams();
        int ends[2];
        if (::pipe(ends) != 0) std::_Exit(1);
        ::close(ends[0]);
        std::_Exit(::write(ends[1], "x", 1) < 0 ? 7 : 1);
      },
      ExitedWithCode(7), "");
}

TEST(StandardStreams, WhatDoesNotReachStdoutIsReported) {
  EXPECT_EXIT(
      {
        ::dup2(::open("/dev/full", O_WRONLY), STDOUT_FILENO);
        std::printf("a line\n");
        const Result<void> done = flush_stdout();
        if (!done) print_error_line(done.error().line());
        std::_Exit(done ? 1 : 7);
      },
      ExitedWithCode(7), "cannot write: standard output: No space left on device");
  EXPECT_TRUE(flush_stdout().ok());
}

TEST(StandardStreams, AnErrorLineIsOneLineThatATerminalCanShow) {
  EXPECT_EXIT(
      {
        print_error_line("no such file: a\x1b[2J\nb");
        std::_Exit(7);
      },
      ExitedWithCode(7), "^no such file: a\\?\\[2J b\n$");
  EXPECT_EXIT(
      {
        ::close(STDERR_FILENO);
        print_error_line("nobody reads this");
        std::_Exit(7);
      },
      ExitedWithCode(7), "");
}

}  // namespace
}  // namespace cliquevo
