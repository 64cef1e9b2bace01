// SPDX-License-Identifier: BSD-3-Clause
// The kernels' tests; with --time instead a table of how fast they are.
#include <cstring>

#include <gtest/gtest.h>

#include "tests/kernels/kernel_times.h"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1 && std::strcmp(argv[1], "--time") == 0) {
    cliquevo::stereo::kernels::print_kernel_times();
    return 0;
  }
  return RUN_ALL_TESTS();
}
