// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/log.h"

#include <atomic>
#include <fcntl.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::daemon {
namespace {

// stderr into a file while it lives.
class Captured {
 public:
  Captured() : path_(test::scratch_dir() + "/err"), old_(::dup(STDERR_FILENO)) {
    const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    ::dup2(file, STDERR_FILENO);
    ::close(file);
  }
  ~Captured() {
    ::dup2(old_, STDERR_FILENO);
    ::close(old_);
  }
  std::string text() const { return test::read_file(path_); }

 private:
  std::string path_;
  int old_;
};

// As SIGHUP does it; before, the logger that others were using went with the change.
TEST(Log, ItsLevelChangesWhileOthersLog) {
  const Captured captured;
  set_up_log("info");
  std::atomic<bool> stop{false};
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&] {
      while (!stop) spdlog::debug("a line that is sometimes written");
    });
  }
  for (int i = 0; i < 300; ++i) set_up_log(i % 2 == 0 ? "debug" : "warn");
  stop = true;
  for (std::thread& thread : threads) thread.join();
  set_up_log("info");
  spdlog::info("the end");
  EXPECT_NE(captured.text().find("the end\n"), std::string::npos);
}

TEST(Log, NoLineHoldsWhatATerminalWouldObey) {
  const Captured captured;
  set_up_log("info");
  spdlog::info("camera \x1b[2J{}", "called\nsomething\x07");
  report({"cannot open", "a\nb\x1b]0;t\x07", "look"});
  const std::string text = captured.text();
  EXPECT_EQ(test::lines_of(text).size(), 2U) << text;
  EXPECT_EQ(text.find("\x1b[2J"), std::string::npos);
  EXPECT_EQ(text.find('\x07'), std::string::npos);
  EXPECT_NE(text.find("cannot open: a b?]0;t?: look\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace cliquevo::daemon
