// SPDX-License-Identifier: BSD-3-Clause
#include "tools/examination.h"

#include <filesystem>
#include <fstream>

#include "tests/support/test_data.h"

namespace cliquevo::tools {
namespace {

namespace fs = std::filesystem;

void put(const std::string& root, const std::string& path, const std::string& text) {
  fs::create_directories((fs::path(root) / path).parent_path());
  std::ofstream(fs::path(root) / path) << text << "\n";
}

Finding find(const std::vector<Finding>& findings, const std::string& subject) {
  for (const Finding& f : findings) {
    if (f.subject == subject) return f;
  }
  ADD_FAILURE() << "nothing about " << subject;
  return {};
}

TEST(Examination, AMachineMadeForItIsFoundGood) {
  const std::string root = test::scratch_dir();
  put(root, "proc/version", "Linux version 6.1.0-rt #1 SMP PREEMPT_RT Debian");
  put(root, "sys/kernel/realtime", "1");
  put(root, "sys/devices/system/cpu/online", "0-3");
  put(root, "sys/devices/system/cpu/isolated", "2-3");
  put(root, "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance");
  put(root, "proc/sys/kernel/sched_rt_runtime_us", "950000");
  put(root, "proc/sys/vm/compact_unevictable_allowed", "0");
  put(root, "proc/sys/net/core/rmem_max", "8388608");
  const auto findings = examine({}, root);
  for (const char* subject : {"kernel preemption", "CPU frequency", "isolated cores", "real-time share", "page faults",
                              "receive buffers", "source and calibration"}) {
    EXPECT_EQ(find(findings, subject).verdict, Verdict::good) << subject << ": " << find(findings, subject).found;
  }
}

TEST(Examination, WhatIsNotGoodComesWithARemedy) {
  const std::string root = test::scratch_dir();
  put(root, "proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC Debian");
  put(root, "sys/devices/system/cpu/online", "0-1");
  put(root, "sys/devices/system/cpu/isolated", "");
  put(root, "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave");
  put(root, "proc/sys/kernel/sched_rt_runtime_us", "0");
  put(root, "proc/sys/vm/compact_unevictable_allowed", "1");
  put(root, "proc/sys/net/core/rmem_max", "212992");
  const auto findings = examine({}, root);
  for (const char* subject :
       {"kernel preemption", "CPU frequency", "isolated cores", "page faults", "receive buffers", "video nodes"}) {
    EXPECT_EQ(find(findings, subject).verdict, Verdict::advice) << subject;
  }
  EXPECT_EQ(find(findings, "real-time share").verdict, Verdict::missing);
  for (const Finding& f : findings) {
    EXPECT_FALSE(f.found.empty()) << f.subject;
    EXPECT_EQ(f.remedy.empty() && f.verdict != Verdict::good, false) << f.subject;
  }
}

TEST(Examination, ABrokenConfigurationIsAFindingToo) {
  const Finding f = find(examine({"/no/such/file.yaml", {}}), "configuration");
  EXPECT_EQ(f.verdict, Verdict::missing);
  EXPECT_NE(f.found.find("/no/such/file.yaml"), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::tools
