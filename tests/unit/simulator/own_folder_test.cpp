// SPDX-License-Identifier: BSD-3-Clause
// Caches on storage that several users share: what others could have written is not read.
#include "drivers/own_folder.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "drivers/simulator/render_cache.h"
#include "tests/support/test_data.h"

namespace cliquevo::drivers {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMost = 1000;

std::string mine() { return "user-" + std::to_string(::geteuid()); }

TEST(OwnFolder, GivesBackWhatItWrote) {
  const std::string path = test::scratch_dir() + "/a/b";
  const auto folder = OwnFolder::open(path);
  ASSERT_TRUE(folder) << folder.error().line();
  EXPECT_FALSE(folder->read("x", kMost));
  ASSERT_TRUE(folder->write("x", std::string_view("one")));
  ASSERT_TRUE(folder->write("x", std::string_view("two")));
  EXPECT_EQ(folder->read("x", kMost), "two");
  EXPECT_FALSE(folder->read("x", 2));
  EXPECT_EQ(folder->names(), std::vector<std::string>{"x"});  // nothing is left of the writing
  folder->remove("x");
  EXPECT_FALSE(folder->written_ns("x"));
}

TEST(OwnFolder, IsOursAloneWhateverTheUmask) {
  const mode_t before = ::umask(0);
  const std::string path = test::scratch_dir() + "/open";
  {
    const auto folder = OwnFolder::open(path);
    ASSERT_TRUE(folder);
    ASSERT_TRUE(folder->write("x", std::string_view("one")));
    EXPECT_EQ(folder->read("x", kMost), "one");
  }
  ::umask(before);
}

TEST(OwnFolder, ReadsNoLinkNoPipeAndNoFileThatOthersMayWrite) {
  const std::string path = test::scratch_dir();
  const auto folder = OwnFolder::open(path);
  ASSERT_TRUE(folder);
  ASSERT_TRUE(folder->write("good", std::string_view("one")));
  fs::create_symlink("good", path + "/link");
  ASSERT_EQ(::mkfifo((path + "/pipe").c_str(), 0600), 0);
  ASSERT_TRUE(folder->write("open", std::string_view("one")));
  fs::permissions(path + "/open", fs::perms::group_write, fs::perm_options::add);
  fs::create_directory(path + "/folder");
  for (const char* name : {"link", "pipe", "open", "folder"}) {
    EXPECT_FALSE(folder->read(name, kMost)) << name;
    EXPECT_FALSE(folder->written_ns(name)) << name;
  }
  // A link where a file is to be is replaced, not written through.
  ASSERT_TRUE(folder->write("link", std::string_view("two")));
  EXPECT_EQ(folder->read("good", kMost), "one");
  EXPECT_EQ(folder->read("link", kMost), "two");
}

TEST(OwnFolder, ALinkOrAFolderThatOthersMayWriteIsRefusedAndSharedOnesHoldOursInAFolderOfItsOwn) {
  const std::string path = test::scratch_dir();
  fs::create_directories(path + "/real");
  fs::create_directory_symlink("real", path + "/link");
  EXPECT_FALSE(OwnFolder::open(path + "/link"));
  fs::create_directories(path + "/shared");
  fs::permissions(path + "/shared", fs::perms::all | fs::perms::sticky_bit);
  EXPECT_FALSE(OwnFolder::open(path + "/shared"));
  const auto ours = OwnFolder::open_shared(path + "/shared");
  ASSERT_TRUE(ours) << ours.error().line();
  EXPECT_EQ(ours->path(), path + "/shared/" + mine());
  // Somebody was there first.
  fs::remove(path + "/shared/" + mine());
  fs::create_directory_symlink(path + "/real", path + "/shared/" + mine());
  EXPECT_FALSE(OwnFolder::open_shared(path + "/shared"));
}

TEST(OwnFolder, AnotherUsersFilesAreNotRead) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  const std::string path = test::scratch_dir();
  const auto folder = OwnFolder::open(path);
  ASSERT_TRUE(folder->write("x", std::string_view("one")));
  ASSERT_EQ(::chown((path + "/x").c_str(), 12345, 12345), 0);
  EXPECT_FALSE(folder->read("x", kMost));
  fs::create_directories(path + "/theirs");
  ASSERT_EQ(::chown((path + "/theirs").c_str(), 12345, 12345), 0);
  const auto refused = folder->below("theirs");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("another user"), std::string::npos);
}

TEST(RenderCache, InAFolderThatOthersMayWriteOursIsApartAndTheirPairsAreNotRead) {
  SimulatorOptions options;
  options.width = 128;
  options.height = 96;
  options.focal_px = 140;
  options.frames = 1;
  options.cache_dir = test::scratch_dir() + "/shared";
  fs::create_directories(options.cache_dir);
  fs::permissions(options.cache_dir, fs::perms::all | fs::perms::sticky_bit);
  StereoPair pair;
  ASSERT_TRUE(*(*open_simulator(options))->next(pair));
  ASSERT_EQ(std::distance(fs::directory_iterator(options.cache_dir), fs::directory_iterator()), 1);
  const fs::path scene = fs::directory_iterator(options.cache_dir + "/" + mine())->path();
  const fs::path file = scene / "000000.pair";
  ASSERT_TRUE(fs::exists(file));
  sim::CleanPair stored;
  EXPECT_TRUE(sim::RenderCache(options).load(0, stored));
  // The same bytes behind a link, and in a file that others may write.
  fs::rename(file, scene / "elsewhere");
  fs::create_symlink("elsewhere", file);
  EXPECT_FALSE(sim::RenderCache(options).load(0, stored));
  fs::remove(file);
  fs::rename(scene / "elsewhere", file);
  fs::permissions(file, fs::perms::others_write, fs::perm_options::add);
  EXPECT_FALSE(sim::RenderCache(options).load(0, stored));
}

TEST(RenderCache, NoneKeepsNothingByOptionAndByEnvironment) {
  const char* before = std::getenv("CLIQUEVO_CACHE");
  const std::string kept = before != nullptr ? before : "";
  ASSERT_EQ(::setenv("CLIQUEVO_CACHE", "none", 1), 0);
  SimulatorOptions options;
  EXPECT_FALSE(sim::RenderCache(options).enabled());
  options.cache_dir = test::scratch_dir() + "/store";
  EXPECT_TRUE(sim::RenderCache(options).enabled()) << "an option wins over the environment";
  options.cache_dir = "none";
  EXPECT_FALSE(sim::RenderCache(options).enabled());
  ASSERT_EQ(before != nullptr ? ::setenv("CLIQUEVO_CACHE", kept.c_str(), 1) : ::unsetenv("CLIQUEVO_CACHE"), 0);
}

}  // namespace
}  // namespace cliquevo::drivers
