// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/thread.h"

#include <atomic>
#include <cstdlib>
#include <pthread.h>
#include <sched.h>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/rt/memory.h"
#include "core/rt/wakeup.h"

namespace cliquevo::rt {
namespace {

TEST(Thread, RunsItsBodyUnderItsNameAndIsJoinedAtTheEnd) {
  std::atomic<bool> ran{false};
  std::string name(16, '\0');
  Wakeup started;
  {
    auto thread = Thread::start({.name = "vo-stereo"}, [&] {
      started.wait(0);
      pthread_getname_np(pthread_self(), name.data(), name.size());
      ran = true;
    });
    ASSERT_TRUE(thread.ok());
    EXPECT_TRUE(thread->shortfall().empty());
    started.signal();
  }
  EXPECT_TRUE(ran);
  EXPECT_STREQ(name.c_str(), "vo-stereo");
}

TEST(Thread, IsOnItsCoreWithItsPriorityOrSaysThatItIsNot) {
  Wakeup started;
  int policy = -1;
  sched_param priority{};
  int core = -1;
  auto thread = Thread::start({.name = "rt", .cpu = 0, .fifo_priority = 10}, [&] {
    started.wait(0);
    pthread_getschedparam(pthread_self(), &policy, &priority);
    core = sched_getcpu();
  });
  ASSERT_TRUE(thread.ok());
  started.signal();
  thread->join();
  if (thread->shortfall().empty()) {
    EXPECT_EQ(policy, SCHED_FIFO);
    EXPECT_EQ(priority.sched_priority, 10);
    EXPECT_EQ(core, 0);
  } else {
    EXPECT_NE(thread->shortfall().find("Operation not permitted"), std::string::npos) << thread->shortfall();
  }
}

TEST(Thread, ABodyThatThrowsEndsTheProgramWithOneLineAndTheCodeThatWasSet) {
  EXPECT_EXIT(
      {
        exceptions_end_with(9);
        ThreadOptions options;
        options.name = "vo-grab";
        auto thread = Thread::start(options, [] { throw std::runtime_error("the camera is gone"); });
        thread->join();
        std::_Exit(1);
      },
      testing::ExitedWithCode(9), "vo-grab.*the camera is gone");
}

TEST(Thread, RunsWithoutACoreThatDoesNotExistAndSaysSo) {
  std::atomic<bool> ran{false};
  auto thread = Thread::start({.name = "rt", .cpu = 1000}, [&] { ran = true; });
  ASSERT_TRUE(thread.ok());
  EXPECT_NE(thread->shortfall().find("core 1000"), std::string::npos);
  thread->join();
  EXPECT_TRUE(ran);
}

TEST(Memory, TheStackCanBePrefaulted) { prefault_stack(256 * 1024); }

}  // namespace
}  // namespace cliquevo::rt
