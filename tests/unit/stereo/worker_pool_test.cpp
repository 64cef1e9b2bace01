// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/worker_pool.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace cliquevo::stereo {
namespace {

TEST(WorkerPool, WhatAShareThrowsComesOutOnceAllAreDone) {
  WorkerPool pool(3);
  for (int round = 0; round < 50; ++round) {
    std::atomic<int> done{0};
    for (const int who : {0, 1, 2}) {
      EXPECT_THROW(pool.run([&](int worker) {
        ++done;
        if (worker == who) throw std::runtime_error("no memory");
      }),
                   std::runtime_error);
    }
    EXPECT_EQ(done, 9);
    EXPECT_THROW(pool.run([](int) { throw std::runtime_error("all of them"); }), std::runtime_error);
    pool.run([&](int) { ++done; });
    EXPECT_EQ(done, 12) << "and the pool goes on";
  }
}

}  // namespace
}  // namespace cliquevo::stereo
