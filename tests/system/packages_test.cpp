// SPDX-License-Identifier: BSD-3-Clause
// The packages on a bare Debian: what they bring along, what each can do without the others, and what an upgrade keeps.
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

constexpr int kMostPackages = 40;
constexpr double kMostMegabytes = 100.0;

std::string folder() { return std::string(CLIQUEVO_BUILD_DIR) + "/packages-test"; }
std::string root() { return folder() + "/root"; }

// With /proc, as every machine and container has it.
Finished in_root(const std::string& line) {
  return Subprocess({"unshare", "--mount", "--propagation", "private", "sh", "-c",
                     R"(mount -t proc proc "$0/proc" && exec chroot "$0" sh -c "$1")", root(), line})
      .wait(600.0);
}

// The package of this name; its file ends in _ARCHITECTURE.deb.
std::string package(const std::string& place, const std::string& name) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder() + "/" + place)) {
    const std::string file = entry.path().filename();
    if (file.starts_with(name + "_") && file.ends_with(".deb")) return entry.path();
  }
  return "";
}

// What this build packs; the last two where their libraries are there.
std::vector<std::string> packages() {
  std::vector<std::string> out{"cliquevo", "cliquevo-tools", "libcliquevo-dev"};
  for (const char* name : {"cliquevo-ros2", "python3-cliquevo"}) {
    if (!package("one", name).empty()) out.emplace_back(name);
  }
  return out;
}

Finished pack(const std::string& place) {
  fs::remove_all(folder() + "/" + place);
  return Subprocess({"cpack", "-G", "DEB", "--config", std::string(CLIQUEVO_BUILD_DIR) + "/CPackConfig.cmake", "-B",
                     folder() + "/" + place},
                    {{"SOURCE_DATE_EPOCH", "1700000000"}})
      .wait(300.0);
}

void put_into_root(const std::string& path, const std::string& name) {
  fs::copy_file(path, root() + "/var/tmp/" + name, fs::copy_options::overwrite_existing);
}

// apt takes the file with all that it depends on.
Finished install(const std::string& name, const std::string& options = "") {
  put_into_root(package("one", name), name + ".deb");
  return in_root("DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends -o Dpkg::Use-Pty=0 " + options +
                 " install /var/tmp/" + name + ".deb </dev/null");
}

class Packages : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (::geteuid() != 0) return;
    fs::create_directories(folder());
    packed_ = pack("one");
    fs::remove_all(root());
    const Finished made = Subprocess({std::string(CLIQUEVO_SOURCE_DIR) + "/tools/debian_root", root()}).wait(900.0);
    why_not_ = made.exit_code == 0 ? "" : made.out + made.err;
    if (!why_not_.empty()) return;
    fs::copy_file("/etc/resolv.conf", root() + "/etc/resolv.conf", fs::copy_options::overwrite_existing);
    in_root("apt-get -qq update");
  }
  static void TearDownTestSuite() { fs::remove_all(root()); }

  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "needs root for a root of its own";
    ASSERT_EQ(packed_.exit_code, 0) << packed_.out << packed_.err;
    ASSERT_EQ(why_not_, "");
  }

  static Finished packed_;
  static std::string why_not_;
};
Finished Packages::packed_;
std::string Packages::why_not_;

TEST_F(Packages, PackedTwiceAreTheSameBytes) {
  const Finished again = pack("two");
  ASSERT_EQ(again.exit_code, 0) << again.out << again.err;
  for (const std::string& name : packages()) {
    EXPECT_EQ(run({"cmp", package("one", name), package("two", name)}).exit_code, 0) << name;
  }
}

TEST_F(Packages, LintianFindsNothing) {
  for (const std::string& name : packages()) {
    const Finished found =
        Subprocess({"lintian", "--allow-root", "--fail-on", "error,warning", package("one", name)}).wait(300.0);
    EXPECT_EQ(found.exit_code, 0) << found.out << found.err;
  }
}

TEST_F(Packages, TheVehiclesPackageIsSmallAndReplaysWithoutTheTools) {
  put_into_root(package("one", "cliquevo"), "cliquevo.deb");
  const std::string before = in_root("dpkg-query -W -f '${Installed-Size}\\n' | awk '{s += $1} END {print s}'").out;
  const std::string count_before = in_root("dpkg-query -W | wc -l").out;
  const Finished installed = install("cliquevo");
  ASSERT_EQ(installed.exit_code, 0) << installed.out << installed.err;
  const std::string after = in_root("dpkg-query -W -f '${Installed-Size}\\n' | awk '{s += $1} END {print s}'").out;
  const std::string count_after = in_root("dpkg-query -W | wc -l").out;
  const int packages = std::stoi(count_after) - std::stoi(count_before);
  const double megabytes = (std::stod(after) - std::stod(before)) * 1024e-6;
  RecordProperty("packages", packages);
  RecordProperty("megabytes", std::to_string(megabytes));
  std::cout << packages << " packages, " << megabytes << " MB\n";
  EXPECT_LE(packages, kMostPackages);
  EXPECT_LE(megabytes, kMostMegabytes);
  EXPECT_NE(in_root("dpkg-query -W libcairo2").exit_code, 0);
  EXPECT_EQ(in_root("dpkg-query -W 'libopencv*' | grep -c .").out, "0\n");

  const Finished played = in_root("cliquevo replay sim:frames=3,cache_dir=none --trajectory /var/tmp/way.txt");
  EXPECT_EQ(played.exit_code, 0) << played.err;
  EXPECT_EQ(lines_of(read_file(root() + "/var/tmp/way.txt")).size(), 3U);
  for (const char* line : {"cliquevo view sim", "cliquevo view --help", "cliquevo replay sim --plot /var/tmp/run.png",
                           "cliquevo replay sim --report /var/tmp/run.html"}) {
    const Finished refused = in_root(line);
    EXPECT_EQ(refused.exit_code, 1) << line;
    EXPECT_EQ(lines_of(refused.err).size(), 1U) << refused.err;
    EXPECT_NE(refused.err.find("install the package cliquevo-tools"), std::string::npos) << refused.err;
  }
  EXPECT_FALSE(fs::exists(root() + "/var/tmp/run.png"));
}

TEST_F(Packages, WithTheToolsTheSameCommandDraws) {
  ASSERT_EQ(install("cliquevo").exit_code, 0);
  const Finished installed = install("cliquevo-tools");
  ASSERT_EQ(installed.exit_code, 0) << installed.out << installed.err;
  const Finished help = in_root("cliquevo view --help");
  EXPECT_EQ(help.exit_code, 0) << help.err;
  EXPECT_NE(help.out.find("--listen"), std::string::npos);
  const Finished drawn = in_root(
      "cliquevo replay sim:frames=3,cache_dir=none --trajectory /var/tmp/drawn.txt --plot /var/tmp/run.png "
      "--report /var/tmp/run.html");
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_EQ(read_file(root() + "/var/tmp/run.png").substr(1, 3), "PNG");
  EXPECT_NE(read_file(root() + "/var/tmp/run.html").find("</html>"), std::string::npos);
  in_root("cliquevo replay sim:frames=3,cache_dir=none --trajectory /var/tmp/plain.txt");
  EXPECT_EQ(read_file(root() + "/var/tmp/plain.txt"), read_file(root() + "/var/tmp/drawn.txt"));
}

TEST_F(Packages, TheBridgeToRos2IsFoundWhereItsPackagePutsIt) {
  if (package("one", "cliquevo-ros2").empty()) GTEST_SKIP() << "built without Cyclone DDS";
  ASSERT_EQ(install("cliquevo").exit_code, 0);
  const Finished missing = in_root("cliquevo ros2 --help");
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_NE(missing.err.find("install cliquevo-ros2"), std::string::npos) << missing.err;
  const Finished installed = install("cliquevo-ros2");
  ASSERT_EQ(installed.exit_code, 0) << installed.out << installed.err;
  EXPECT_EQ(in_root("cliquevo ros2 --help").exit_code, 0);
}

TEST_F(Packages, TheDaemonFindsItsConfigurationAndPiecesBesideIt) {
  ASSERT_EQ(install("cliquevo").exit_code, 0);
  fs::create_directories(root() + "/etc/cliquevo/cliquevo.yaml.d");
  std::ofstream(root() + "/etc/cliquevo/cliquevo.yaml.d/50-rig.yaml") << "stereo:\n  window: 13\n";
  const Finished check = in_root("cliquevod --check");
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_NE(check.out.find("window: 13"), std::string::npos) << check.out;
  EXPECT_NE(in_root("cliquevod --check --set stereo.window=11").out.find("window: 11"), std::string::npos);
  fs::remove_all(root() + "/etc/cliquevo/cliquevo.yaml.d");
}

// The previous version's one package had all files, the library's too.
TEST_F(Packages, AnUpgradeKeepsTheConfigurationAndTakesTheFilesOver) {
  in_root("dpkg --purge cliquevo-ros2 cliquevo-tools cliquevo libcliquevo-dev");
  const std::string old = folder() + "/old";
  fs::remove_all(old);
  ASSERT_EQ(run({"dpkg-deb", "-R", package("one", "cliquevo"), old}).exit_code, 0);
  for (const char* name : {"libcliquevo-dev", "cliquevo-tools"}) {
    ASSERT_EQ(run({"dpkg-deb", "-x", package("one", name), old}).exit_code, 0);
  }
  ASSERT_EQ(run({"sed", "-i", "s/^Version: .*/Version: 0.1.0/", old + "/DEBIAN/control"}).exit_code, 0);
  std::ofstream(old + "/etc/cliquevo/cliquevo.yaml") << "log:\n  level: warn\n";
  ASSERT_EQ(run({"dpkg-deb", "-Znone", "-b", old, root() + "/var/tmp/old.deb"}).exit_code, 0);
  const Finished first = in_root("apt-get -qq -y --no-install-recommends install /var/tmp/old.deb </dev/null");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  std::ofstream(root() + "/etc/cliquevo/cliquevo.yaml") << "log:\n  level: debug  # mine\n";

  const Finished upgraded = install("cliquevo", "-o Dpkg::Options::=--force-confold");
  ASSERT_EQ(upgraded.exit_code, 0) << upgraded.out << upgraded.err;
  EXPECT_EQ(read_file(root() + "/etc/cliquevo/cliquevo.yaml"), "log:\n  level: debug  # mine\n");
  EXPECT_EQ(in_root("dpkg-query -W -f '${Version}' cliquevo").out, CLIQUEVO_VERSION);
  EXPECT_EQ(install("cliquevo-tools").exit_code, 0);
  EXPECT_EQ(install("libcliquevo-dev").exit_code, 0);
  EXPECT_TRUE(fs::exists(root() + "/usr/lib/x86_64-linux-gnu/cmake/cliquevo/cliquevo-config.cmake") ||
              fs::exists(root() + "/usr/lib/cmake/cliquevo/cliquevo-config.cmake"));
  in_root("apt-get -qq -y remove cliquevo");
  EXPECT_TRUE(fs::exists(root() + "/etc/cliquevo/cliquevo.yaml"));
}

}  // namespace
}  // namespace cliquevo::test
