// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/config.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <type_traits>
#include <variant>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "daemon/pipeline/command_line.h"
#include "daemon/pipeline/keys/keys.h"
#include "tests/support/test_data.h"

namespace cliquevo::daemon {
namespace {

std::string shipped() { return std::string(CLIQUEVO_SOURCE_DIR) + "/config/cliquevo.yaml"; }

std::string file_with(const std::string& text) {
  const std::string path = test::scratch_dir() + "/c.yaml";
  std::ofstream(path) << text;
  return path;
}

std::string refusal(const std::string& text) {
  const auto read = read_config(file_with(text));
  return read ? "" : read.error().line();
}

// "a.b.c" -> the YAML that sets it.
std::string setting(const std::string& key, const std::string& value) {
  std::string out;
  std::string indent;
  std::istringstream parts(key);
  for (std::string part; std::getline(parts, part, '.'); indent += "  ")
    out += (out.empty() ? "" : "\n") + indent + part + ":";
  return out + " " + value + "\n";
}

// How many fields an aggregate has: the longest list of anything that initialises it.
struct Anything {
  template <typename T>
  operator T() const {  // NOLINT(google-explicit-constructor)
    return T{};
  }
};
template <typename T, typename... Fields>
constexpr std::size_t count_fields() {
  if constexpr (requires { T{Fields{}..., Anything{}}; }) {
    return count_fields<T, Fields..., Anything>();
  } else {
    return sizeof...(Fields);
  }
}

std::size_t count_keys(const std::string& section) {
  std::size_t count = 0;
  for (const auto& [key, value] : list_config(default_config())) {
    if (key.starts_with(section + ".")) ++count;
  }
  return count;
}

TEST(Config, TheShippedFileHoldsEveryKeyWithItsCompiledDefault) {
  const auto read = read_config(shipped());
  ASSERT_TRUE(read.ok()) << read.error().line();
  const auto defaults = list_config(default_config());
  const auto values = list_config(*read);
  ASSERT_EQ(defaults.size(), values.size());
  const YAML::Node file = YAML::LoadFile(shipped());
  for (std::size_t i = 0; i < defaults.size(); ++i) {
    EXPECT_EQ(values[i], defaults[i]);
    YAML::Node node;
    node.reset(file);
    std::istringstream parts(defaults[i].first);
    for (std::string part; std::getline(parts, part, '.') && node.IsDefined();) node.reset(node[part]);
    EXPECT_TRUE(node.IsDefined()) << defaults[i].first << " is missing in config/cliquevo.yaml: run tools/generate";
  }
}

TEST(Config, EveryParameterOfRectificationStereoAndOdometryHasAKey) {
  EXPECT_EQ(count_keys("stereo"), count_fields<stereo::StereoParams>())
      << "a field without a row in daemon/pipeline/keys";
  EXPECT_EQ(count_keys("rectify"), count_fields<stereo::RectifyParams>())
      << "a field without a row in daemon/pipeline/keys";
  EXPECT_EQ(count_keys("odometry"), count_fields<vo::VoParams>()) << "a field without a row in daemon/pipeline/keys";
}

TEST(Config, EveryOptionOfTheSimulatorHasAKey) {
  // The three angles of misalign_right_deg are fields of their own to the counter, and one key.
  EXPECT_EQ(count_keys("source.simulator") + 2, count_fields<drivers::SimulatorOptions>())
      << "a field without a row in daemon/pipeline/keys";
}

TEST(Config, EveryKeySaysWhatItMeans) {
  Config config = default_config();
  const KeyTable table = config_keys(config);
  for (const Key& key : table.keys()) EXPECT_FALSE(key.meaning.empty()) << key.name;
}

TEST(Config, EveryDefaultIsWithinItsRange) {
  Config config = default_config();
  const KeyTable table = config_keys(config);
  for (const Key& key : table.keys()) EXPECT_TRUE(key.check().ok()) << key.name;
}

bool is_number(const Key& key) {
  return std::holds_alternative<int*>(key.field) || std::holds_alternative<std::int64_t*>(key.field) ||
         std::holds_alternative<double*>(key.field) || std::holds_alternative<std::optional<double>*>(key.field);
}
bool is_whole(const Key& key) {
  return !std::holds_alternative<double*>(key.field) && !std::holds_alternative<std::optional<double>*>(key.field);
}

// What is said of the key when it is set to a number in a file.
std::string refusal_of(const Key& key, double value) {
  const auto text = is_whole(key) ? std::to_string(std::lround(value)) : fmt::format("{}", value);
  return refusal(setting(key.name, text));
}

// A range is a promise: both ends are accepted, what lies beyond is refused with its line. At an end another key may
// object (a wide image to a short focal length); beyond it this one must.
TEST(Config, TheRangesAreKeptToTheLastValue) {
  Config config = default_config();
  int ranges = 0;
  const KeyTable table = config_keys(config);
  for (const Key& key : table.keys()) {
    if (!is_number(key) || !key.range.low) continue;
    ++ranges;
    const double step = is_whole(key) ? key.range.multiple_of * (key.range.odd ? 2.0 : 1.0) : 1e-6;
    const std::size_t line = 1 + static_cast<std::size_t>(std::count(key.name.begin(), key.name.end(), '.'));
    const auto blamed = [&](double v) {
      const std::string said = refusal_of(key, v);
      return said.find("(" + key.name + " =") != std::string::npos &&
             said.find(fmt::format("c.yaml:{}:", line)) != std::string::npos;
    };
    EXPECT_EQ(key.range.contains(*key.range.low), !key.range.low_is_open) << key.name;
    EXPECT_TRUE(blamed(*key.range.low - step)) << key.name << " below " << *key.range.low;
    if (!key.range.high) continue;
    EXPECT_TRUE(blamed(*key.range.high + step)) << key.name << " above " << *key.range.high;
  }
  EXPECT_GT(ranges, 80);
}

// Whoever uses a library without a configuration file relies on its own check: it must know the same ranges.
TEST(Config, TheLibrariesOwnChecksKnowTheSameRanges) {
  Config config = default_config();
  const KeyTable table = config_keys(config);
  for (const Key& key : table.keys()) {
    const bool of_a_library = key.name.starts_with("stereo.") || key.name.starts_with("rectify.") ||
                              key.name.starts_with("odometry.") || key.name.starts_with("source.cameras.") ||
                              key.name.starts_with("source.simulator.");
    if (!of_a_library || !is_number(key)) continue;
    const auto refused = [&](double v) {
      const Config before = config;
      std::visit(
          [v](auto field) {
            using Pointer = decltype(field);
            if constexpr (std::is_same_v<Pointer, int*>) *field = static_cast<int>(v);
            if constexpr (std::is_same_v<Pointer, std::int64_t*>) *field = static_cast<std::int64_t>(v);
            if constexpr (std::is_same_v<Pointer, double*> || std::is_same_v<Pointer, std::optional<double>*>) {
              *field = v;
            }
          },
          key.field);
      const bool ok = config.stereo.check().ok() && config.rectify.check().ok() && config.odometry.check().ok() &&
                      config.source.cameras.check().ok() && config.source.simulator.check().ok();
      config = before;
      return !ok;
    };
    const double step = is_whole(key) ? 1.0 : 1e-6;
    if (key.range.low) {
      EXPECT_TRUE(refused(*key.range.low - step))
          << key.name << ": its library's check() takes less: add the range there";
    }
    if (key.range.high) {
      EXPECT_TRUE(refused(*key.range.high + step))
          << key.name << ": its library's check() takes more: add the range there";
    }
  }
}

TEST(Config, AnEmptyFileIsTheDefaults) {
  const auto read = read_config(file_with("# nothing\nstereo:\n"));
  ASSERT_TRUE(read.ok()) << read.error().line();
  EXPECT_EQ(list_config(*read), list_config(default_config()));
}

TEST(Config, ValuesOfEveryKindAreRead) {
  const auto read =
      read_config(file_with("source:\n  type: recording\n  recording: {path: /data/x, rate_hz: 12.5, first: 3}\n"
                            "stereo: {window: 11, prefilter: none}\nodometry:\n  refine: false\n"
                            "lcm: {url: 'udpm://239.1.1.1:7000?ttl=1'}\nbody: {translation_m: [1, 2.5, -3]}\n"));
  ASSERT_TRUE(read.ok()) << read.error().line();
  EXPECT_EQ(read->source.type, "recording");
  EXPECT_EQ(read->source.recording.path, "/data/x");
  EXPECT_EQ(read->source.recording.rate_hz, 12.5);
  EXPECT_EQ(read->source.recording.first, 3);
  EXPECT_EQ(read->stereo.window, 11);
  EXPECT_EQ(read->stereo.prefilter, stereo::Prefilter::none);
  EXPECT_FALSE(read->odometry.refine);
  EXPECT_EQ(read->lcm.url, "udpm://239.1.1.1:7000?ttl=1");
  EXPECT_EQ(read->T_body_camera.t, Eigen::Vector3d(1, 2.5, -3));
}

TEST(Config, RelativePathsStartFromTheFile) {
  const std::string path =
      file_with("source: {recording: {path: ../run, calibration: calib.txt, left_mask: /m.png}}\n");
  const auto read = read_config(path);
  ASSERT_TRUE(read.ok()) << read.error().line();
  const std::string folder = path.substr(0, path.rfind('/'));
  EXPECT_EQ(read->source.recording.calibration, folder + "/calib.txt");
  EXPECT_EQ(read->source.recording.path, folder.substr(0, folder.rfind('/')) + "/run");
  EXPECT_EQ(read->source.recording.left_mask, "/m.png");
  EXPECT_EQ(read->source.recording.right_mask, "");
}

TEST(Config, SettingsWinOverFilesAndLaterFilesOverEarlierOnes) {
  const std::string dir = test::scratch_dir();
  std::ofstream(dir + "/cliquevo.yaml") << "stereo: {window: 11, workers: 1}\nlog: {level: warn}\n";
  std::filesystem::create_directory(dir + "/cliquevo.yaml.d");
  std::ofstream(dir + "/cliquevo.yaml.d/20-b.yaml") << "stereo: {window: 15}\n";
  std::ofstream(dir + "/cliquevo.yaml.d/10-a.yaml") << "stereo: {window: 13, num_disparities: 32}\n";
  std::ofstream(dir + "/cliquevo.yaml.d/ignored.txt") << "no configuration";
  EXPECT_EQ(config_files_in(dir).size(), 3U);
  const auto found = read_daemon_config({"", {"stereo.num_disparities=48", "lcm.url=file:///tmp/a: b?mode=w"}}, dir);
  ASSERT_TRUE(found.ok()) << found.error().line();
  EXPECT_EQ(found->stereo.window, 15);
  EXPECT_EQ(found->stereo.workers, 1);
  EXPECT_EQ(found->stereo.num_disparities, 48);
  EXPECT_EQ(found->log_level, "warn");
  EXPECT_EQ(found->lcm.url, "file:///tmp/a: b?mode=w");
  // A file that is named stands alone.
  const auto named = read_daemon_config({dir + "/cliquevo.yaml.d/20-b.yaml", {}}, dir);
  ASSERT_TRUE(named.ok());
  EXPECT_EQ(named->log_level, default_config().log_level);
  EXPECT_TRUE(config_files_in(dir + "/nowhere").empty());
}

TEST(Config, SettingsThatAreWrongAreNamed) {
  const auto refused = [](const std::string& setting) {
    const auto read = read_config(ConfigSources{{}, {setting}});
    return read ? "" : read.error().line();
  };
  EXPECT_NE(
      refused("stereo.windw=11").find("unknown key 'stereo.windw': --set stereo.windw=11: did you mean 'window'?"),
      std::string::npos)
      << refused("stereo.windw=11");
  EXPECT_NE(refused("sterio.window=11").find("did you mean 'stereo'?"), std::string::npos);
  EXPECT_NE(refused("stereo.window=twelve").find("wrong value for 'stereo.window': --set stereo.window=twelve"),
            std::string::npos);
  EXPECT_NE(refused("stereo.window=12").find("--set stereo.window=12"), std::string::npos);
  EXPECT_NE(refused("stereo=12").find("unknown key 'stereo'"), std::string::npos);
  for (const char* none : {"", "=", "stereo.window", "=5"})
    EXPECT_NE(refused(none).find("not a setting"), std::string::npos);
  EXPECT_FALSE(refused("stereo.window=*a").empty());
  EXPECT_FALSE(refused("stereo.window=[[[[[[[[[[[[[[[[[[[[[[[1").empty());
}

TEST(Config, WhatIsWrongIsNamedWithItsLine) {
  const struct {
    std::string text;
    std::string says;
  } cases[] = {
      {"stereo:\n  windw: 9\n", "unknown key 'stereo.windw': FILE:2: did you mean 'window'?"},
      {"sterio:\n  window: 9\n", "unknown key 'sterio': FILE:1: did you mean 'stereo'?"},
      {"lcm:\n  nonsense_altogether: 9\n", "FILE:2: known keys are"},
      {"stereo:\n  window: wide\n", "wrong value for 'stereo.window': FILE:2: give a whole number; the default is 13"},
      {"stereo:\n  window: 9.5\n", "FILE:2: give a whole number"},
      {"stereo:\n  window: 99999999999999\n", "FILE:2: give a whole number"},
      {"stereo:\n  window: [9]\n", "FILE:2: give a whole number"},
      {"stereo:\n  window:\n", "FILE:2: give a whole number"},
      {"source:\n  speed: .nan\n", "FILE:2: give a number"},
      {"source:\n  speed: 1e999\n", "FILE:2: give a number"},
      {"source:\n  simulator:\n    world_seed: -1\n", "FILE:3: give a whole number, not negative"},
      {"odometry:\n  refine: maybe\n", "FILE:2: give true or false"},
      {"source:\n  type: camera\n", "FILE:2: give one of simulator, recording"},
      {"body:\n  translation_m: [1, 2]\n", "FILE:2: give three numbers"},
      {"body:\n\n  translation_m: [1, 2, x]\n", "FILE:3: give three numbers"},
      {"source: {recording: {rate_hz: fast}}\n", "FILE:1: give a number or auto"},
      {"stereo:\n  window: 8\n", "FILE:2: give an odd number"},
      {"lcm:\n  pose_channel: ''\n", "FILE:2: give a name of 1 to 63 characters"},
      {"source:\n  type: recording\n", "source.recording.path"},
      {"stereo:\n  window: 9\n  window: 7\n", "key 'stereo.window' twice: FILE:3"},
      {"stereo: 5\n", "'stereo' is a section: FILE:1"},
      {"stereo:\n  window: {a: b}\n", "FILE:2: give a whole number"},
      {"stereo:\n  window: [9\nlcm: 1\n", "cannot read configuration: FILE:"},
      {"- a\n- b\n", "cannot read configuration: FILE"},
      {"[a, b]: c\n", "not a key: FILE:1"},
  };
  for (const auto& bad : cases) {
    const std::string path = file_with(bad.text);
    const auto read = read_config(path);
    ASSERT_FALSE(read.ok()) << bad.text;
    std::string line = read.error().line();
    for (std::size_t at = line.find(path); at != std::string::npos; at = line.find(path))
      line.replace(at, path.size(), "FILE");
    EXPECT_NE(line.find(bad.says), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  }
  EXPECT_FALSE(read_config("/nowhere/c.yaml").ok());
  EXPECT_FALSE(read_config("/tmp").ok());
}

TEST(Config, ACameraMountedWithoutTurnLooksForward) {
  const RigidTransform T = default_config().T_body_camera;
  EXPECT_NEAR((T * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 0, 0)).norm(), 0, 1e-15);  // ahead is X
  EXPECT_NEAR((T * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((T * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(0, 0, -1)).norm(), 0, 1e-15);
}

TEST(Config, PositivePitchLooksDownAndPositiveYawToTheLeft) {
  Mounting mounting;
  mounting.roll_pitch_yaw_deg = {0, 30, 0};
  const Eigen::Vector3d down = mounting.T_body_camera() * Eigen::Vector3d(0, 0, 1);
  EXPECT_NEAR(down.z(), -0.5, 1e-12);
  mounting.roll_pitch_yaw_deg = {0, 0, 90};
  const Eigen::Vector3d left = mounting.T_body_camera() * Eigen::Vector3d(0, 0, 1);
  EXPECT_NEAR(left.y(), 1.0, 1e-12);
}

TEST(Config, WhatIsMadeToBeCostlyIsRefused) {
  EXPECT_NE(refusal("stereo: &s {window: 9}\nodometry: *s\n").find(":2: aliases"), std::string::npos);
  EXPECT_EQ(refusal("stereo: &s {window: 9}\n"), "") << "a name alone costs nothing";
  EXPECT_NE(refusal(std::string(300'000, '#')).find("256 kB"), std::string::npos);
  EXPECT_NE(refusal("stereo: " + std::string(40, '[') + std::string(40, ']') + "\n").find("too deeply"),
            std::string::npos);
  std::string many = "stereo: [";
  for (int i = 0; i < 20'000; ++i) many += "1,";
  EXPECT_NE(refusal(many + "1]\n").find("too many"), std::string::npos);
  EXPECT_NE(refusal("\x01\x02\x03").find("cannot read"), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::daemon
