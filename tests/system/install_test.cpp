// SPDX-License-Identifier: BSD-3-Clause
// What `cmake --install` puts in place, and the examples: programs of somebody else's that link the library from there.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

namespace fs = std::filesystem;
using test::Finished;

const std::string kSource = CLIQUEVO_SOURCE_DIR;

// The installed tree, made once.
const std::string& installed() {
  static const std::string root = [] {
    std::string folder = test::scratch_dir() + "/root";
    const Finished done = test::run({"cmake", "--install", CLIQUEVO_BUILD_DIR}, {{"DESTDIR", folder}});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return folder;
  }();
  return root;
}

// Builds a project outside the tree, with warnings as errors; returns its build folder.
std::string build(const std::string& project, const std::vector<std::string>& options) {
  const std::string folder = test::scratch_dir() + "/build";
  std::vector<std::string> configure = {"cmake", "-G", "Ninja", "-S", project, "-B", folder};
  configure.insert(configure.end(), options.begin(), options.end());
  const Finished configured = test::run(
      configure, {{"CXXFLAGS", "-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Werror"}});
  EXPECT_EQ(configured.exit_code, 0) << configured.out << configured.err;
  test::Subprocess compiling({"cmake", "--build", folder});
  const Finished built = compiling.wait(1200.0);  // the whole library, where it is part of the project
  EXPECT_EQ(built.exit_code, 0) << built.out << built.err;
  return folder;
}

std::string build_example(const std::string& name) {
  return build(kSource + "/examples/" + name,
               {"-DCMAKE_PREFIX_PATH=" + installed() + "/usr", "-DCMAKE_BUILD_TYPE=Release"});
}

TEST(Install, PutsAllInPlace) {
  const std::string& root = installed();
  for (const char* path :
       {"usr/bin/cliquevo", "usr/bin/cliquevod", "usr/lib/systemd/system/cliquevod.service",
        "usr/lib/sysusers.d/cliquevo.conf", "usr/lib/sysctl.d/60-cliquevo.conf",
        "usr/lib/udev/rules.d/60-cliquevo.rules", "etc/cliquevo/cliquevo.yaml",
        "usr/share/cliquevo/lcmtypes/pose_t.lcm", "usr/share/doc/cliquevo/examples/network-cameras.conf",
        "usr/include/cliquevo/odometry.h", "usr/include/cliquevo/version.h"}) {
    EXPECT_TRUE(fs::exists(fs::path(root) / path)) << path;
  }
  const Finished check =
      test::run({root + "/usr/bin/cliquevod", "--config", root + "/etc/cliquevo/cliquevo.yaml", "--check"});
  EXPECT_EQ(check.exit_code, 0) << check.err;
}

TEST(Install, HeadersStayBelowOneFolderAndIncludeEachOtherByIt) {
  int headers = 0;
  for (const auto& entry : fs::recursive_directory_iterator(installed() + "/usr/include")) {
    if (!entry.is_regular_file()) continue;
    ++headers;
    EXPECT_EQ(entry.path().parent_path(), fs::path(installed()) / "usr/include/cliquevo") << entry.path();
    for (const std::string& line : test::lines_of(test::read_file(entry.path().string()))) {
      EXPECT_FALSE(line.starts_with("#include \"")) << entry.path() << ": " << line;
    }
  }
  EXPECT_GT(headers, 15);
}

TEST(Install, TheTenLinesOfTheLibraryFollowTheCamera) {
  const std::string text = test::read_file(kSource + "/examples/01_library/main.cpp");
  const std::size_t begin = text.find("// [ten lines]\n");
  const std::string ten = text.substr(begin + 15, text.find("  // [end]") - begin - 15);
  EXPECT_EQ(std::count(ten.begin(), ten.end(), '\n'), 11);  // the last one is a brace
  const Finished ran = test::run({build_example("01_library") + "/library"});
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
  EXPECT_EQ(test::lines_of(ran.out).size(), 5u);
}

TEST(Install, AProgramReceivesWhatIsPublished) {
  const std::string log = test::scratch_dir() + "/run.lcm";
  const Finished replayed = test::run({installed() + "/usr/bin/cliquevo", "replay",
                                       "sim:width=320,height=240,focal_px=350,frames=7,cache_dir=none", "--lcm",
                                       "file://" + log + "?mode=w"});
  ASSERT_EQ(replayed.exit_code, 0) << replayed.err;
  const std::string program = build_example("02_subscribe_lcm") + "/subscribe_lcm";
  const Finished ran = test::run({program, "file://" + log + "?speed=0"});
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
  EXPECT_NE(ran.out.find("\n7 poses\n"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("status 1, quality "), std::string::npos) << ran.out;
  const std::string three = test::run({program, "file://" + log + "?speed=0", "3"}).out;
  EXPECT_TRUE(three.ends_with("\n3 poses\n")) << three;
  EXPECT_EQ(test::run({program, "nonsense"}).exit_code, 1);
}

TEST(Install, ACameraOfOnesOwnIsRectifiedAndFollowed) {
  const Finished ran = test::run({build_example("03_own_camera") + "/own_camera"});
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
  EXPECT_NE(ran.out.find("quality"), std::string::npos);
}

TEST(Install, AnotherProjectHasTheLibraryByAddSubdirectory) {
  const std::string project = test::scratch_dir() + "/project";
  fs::create_directories(project);
  std::ofstream(project + "/CMakeLists.txt")
      << "cmake_minimum_required(VERSION 3.25)\nproject(robot LANGUAGES C CXX)\n"
      << "add_subdirectory(" << kSource << " cliquevo)\n"
      << "add_executable(robot " << kSource << "/examples/01_library/main.cpp)\n"
      << "target_link_libraries(robot PRIVATE cliquevo::odometry)\n"
      << "get_target_property(include cliquevo_headers INTERFACE_INCLUDE_DIRECTORIES)\n"
      << "if(include MATCHES \"" << kSource << "(;|>|$)\")\n  message(FATAL_ERROR \"our own folder leaks\")\nendif()\n";
  const Finished ran = test::run({build(project, {}) + "/robot"});
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
}

}  // namespace
}  // namespace cliquevo
