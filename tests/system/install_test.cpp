// SPDX-License-Identifier: BSD-3-Clause
// What `cmake --install` puts in place, and a program of somebody else's that links the library from there.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

namespace fs = std::filesystem;

TEST(Install, PutsAllInPlaceAndAnotherProjectLinksTheLibrary) {
  const std::string dir = test::scratch_dir();
  const std::string root = dir + "/root";
  const test::Finished installed = test::run({"cmake", "--install", CLIQUEVO_BUILD_DIR}, {{"DESTDIR", root}});
  ASSERT_EQ(installed.exit_code, 0) << installed.err;
  for (const char* path :
       {"usr/bin/cliquevo", "usr/bin/cliquevod", "usr/lib/systemd/system/cliquevod.service",
        "usr/lib/sysusers.d/cliquevo.conf", "usr/lib/sysctl.d/60-cliquevo.conf",
        "usr/lib/udev/rules.d/60-cliquevo.rules", "etc/cliquevo/cliquevo.yaml",
        "usr/share/cliquevo/lcmtypes/pose_t.lcm", "usr/share/doc/cliquevo/examples/network-cameras.conf"}) {
    EXPECT_TRUE(fs::exists(fs::path(root) / path)) << path;
  }
  const test::Finished check =
      test::run({root + "/usr/bin/cliquevod", "--config", root + "/etc/cliquevo/cliquevo.yaml", "--check"});
  EXPECT_EQ(check.exit_code, 0) << check.err;

  const std::string example = std::string(CLIQUEVO_SOURCE_DIR) + "/tests/system/example_project";
  const test::Finished configured = test::run({"cmake", "-G", "Ninja", "-S", example, "-B", dir + "/build",
                                               "-DCMAKE_PREFIX_PATH=" + root + "/usr", "-DCMAKE_BUILD_TYPE=Release"});
  ASSERT_EQ(configured.exit_code, 0) << configured.out << configured.err;
  const test::Finished built = test::run({"cmake", "--build", dir + "/build"});
  ASSERT_EQ(built.exit_code, 0) << built.out << built.err;
  const test::Finished ran = test::run({dir + "/build/example"});
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
}

}  // namespace
}  // namespace cliquevo
