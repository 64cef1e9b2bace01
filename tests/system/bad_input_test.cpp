// SPDX-License-Identifier: BSD-3-Clause
// Bad input, each kind through the real binary: the right exit code and one clear line `what: where: what to do`.
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/made_recording.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

std::string file_with(const std::string& name, const std::string& text) {
  const std::string path = scratch_dir() + "/" + name;
  std::ofstream(path) << text;
  return path;
}

// The one line that `cliquevo` says before it exits with `exit_code`; `naming` must be in it.
void expect_refused(std::vector<std::string> arguments, int exit_code, const std::string& naming) {
  const std::string shown = fmt::format("cliquevo {}", fmt::join(arguments, " "));
  arguments.insert(arguments.begin(), binary("cliquevo"));
  const Finished done = run(arguments);
  EXPECT_EQ(done.exit_code, exit_code) << shown << "\n" << done.err;
  EXPECT_EQ(lines_of(done.err).size(), 1u) << shown << "\n" << done.err;
  EXPECT_NE(done.err.find(naming), std::string::npos) << shown << "\n" << done.err;
  EXPECT_GE(std::count(done.err.begin(), done.err.end(), ':'), 2) << "not `what: where: what to do`: " << done.err;
}

TEST(BadInput, AMissingFolder) { expect_refused({"replay", "/nowhere/run"}, 1, "/nowhere/run"); }

TEST(BadInput, AnEmptyFolder) {
  const std::string folder = scratch_dir();
  expect_refused({"replay", folder}, 1, folder);
}

TEST(BadInput, AFileInsteadOfAFolder) {
  const std::string file = file_with("run", "x");
  expect_refused({"replay", file}, 1, file);
}

TEST(BadInput, OneCameraMissing) {
  const std::string recording = made_recording();
  fs::remove_all(recording + "/image_1");
  expect_refused({"replay", recording}, 1, recording);
}

TEST(BadInput, OneCameraEmpty) {
  const std::string recording = made_recording();
  fs::remove_all(recording + "/image_1");
  fs::create_directory(recording + "/image_1");
  expect_refused({"replay", recording}, 1, recording);
}

TEST(BadInput, CamerasOfUnequalSize) {
  const std::string recording = made_recording();
  for (int i = 0; i < 6; ++i) {
    cv::Mat image = cv::imread(image_of(recording, 1, i));
    cv::resize(image, image, {300, 240});
    cv::imwrite(image_of(recording, 1, i), image);
  }
  expect_refused({"replay", recording}, 1, "300x240");
}

// The pair is skipped, reported and counted; its line of the trajectory holds the pose before it. --strict ends there.
void expect_skipped(const std::string& recording, int pair, const std::string& naming) {
  const std::string trajectory = scratch_dir() + "/t.txt";
  const std::string stats = scratch_dir() + "/s.json";
  const Finished done = run({binary("cliquevo"), "replay", recording, "--trajectory", trajectory, "--stats", stats});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(lines_of(done.err).size(), 1u) << done.err;
  EXPECT_EQ(done.err.rfind(fmt::format("warning: skipped pair {}", pair), 0), 0u) << done.err;
  EXPECT_NE(done.err.find(naming), std::string::npos) << done.err;
  EXPECT_NE(done.out.find("skipped      1 pair,"), std::string::npos) << done.out;
  EXPECT_NE(read_file(stats).find("\"skipped\":1"), std::string::npos);
  EXPECT_NE(read_file(stats).find("\"frames\":5"), std::string::npos);
  const std::vector<std::string> poses = lines_of(read_file(trajectory));
  ASSERT_EQ(poses.size(), 6u);
  if (pair > 0) {
    EXPECT_EQ(poses[static_cast<std::size_t>(pair)], poses[static_cast<std::size_t>(pair) - 1]);
  }
  expect_refused({"replay", recording, "--strict"}, 3, naming);
}

TEST(BadInput, OneImageOfAnotherSizeAmongThemIsSkipped) {
  const std::string recording = made_recording();
  cv::Mat image = cv::imread(image_of(recording, 0, 3));
  cv::resize(image, image, {300, 240});
  cv::imwrite(image_of(recording, 0, 3), image);
  expect_skipped(recording, 3, image_of(recording, 0, 3));
}

TEST(BadInput, ATornImageIsSkipped) {
  const std::string recording = made_recording();
  tear(image_of(recording, 1, 4));
  expect_skipped(recording, 4, image_of(recording, 1, 4));
}

TEST(BadInput, AFirstImageThatIsTornOrNoImageIsSkipped) {
  std::string recording = made_recording();
  tear(image_of(recording, 0, 0));
  expect_skipped(recording, 0, image_of(recording, 0, 0));
  recording = made_recording();
  std::ofstream(image_of(recording, 0, 0)) << "not an image";
  expect_skipped(recording, 0, image_of(recording, 0, 0));
}

TEST(BadInput, AStampThatRepeatsIsSkipped) {
  const std::string recording = made_recording();
  std::ofstream(recording + "/times.txt") << "0\n0.1\n0.2\n0.2\n0.4\n0.5\n";
  expect_skipped(recording, 3, "repeats");
}

TEST(BadInput, ARecordingWithoutAnyImageThatCanBeRead) {
  const std::string recording = made_recording();
  for (int i = 0; i < 6; ++i) tear(image_of(recording, 1, i));
  expect_refused({"replay", recording}, 1, image_of(recording, 1, 0));
}

TEST(BadInput, TrajectoriesBeyondReasonAreRefused) {
  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n";
  const std::string fine = file_with("good.txt", good);
  for (const char* row : {"1 0 0 1e200 0 1 0 0 0 0 1 0\n", "1 0 0 nan 0 1 0 0 0 0 1 0\n", "1 0 0 inf 0 1 0 0 0 0 1 0\n",
                          "nan 0 0 0 0 1 0 0 0 0 1 0\n"}) {
    const std::string bad = file_with("bad.txt", good + row);
    expect_refused({"eval", "--reference", bad, "--estimate", fine}, 1, "bad.txt:3");
    expect_refused({"eval", "--reference", fine, "--estimate", bad}, 1, "bad.txt:3");
  }
  const std::string tum = file_with("bad.tum", "0 0 0 0 0 0 0 1\n1e19 0 0 0 0 0 0 1\n");
  expect_refused({"eval", "--reference", tum, "--estimate", tum}, 1, "bad.tum:2");
}

TEST(BadInput, ACalibrationThatIsMissingOrNone) {
  std::string recording = made_recording();
  fs::remove(recording + "/calib.txt");
  expect_refused({"replay", recording}, 1, recording);
  recording = made_recording();
  std::ofstream(recording + "/calib.txt") << "nothing of use\n";
  expect_refused({"replay", recording}, 1, "calib.txt");
  expect_refused({"replay", recording, "--calibration", "/nowhere/calib.txt"}, 1, "/nowhere/calib.txt");
}

// One of another shape: a mere change of resolution is scaled, and said.
TEST(BadInput, ACalibrationOfAnotherSize) {
  const std::string calibration =
      file_with("camchain.yaml",
                "cam0:\n  camera_model: pinhole\n  intrinsics: [350, 350, 320, 200]\n  distortion_model: radtan\n"
                "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 400]\n"
                "cam1:\n  camera_model: pinhole\n  intrinsics: [350, 350, 320, 200]\n  distortion_model: radtan\n"
                "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 400]\n"
                "  T_cn_cnm1: [[1, 0, 0, -0.12], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n");
  expect_refused({"replay", made_recording(), "--calibration", calibration}, 1, "640x400");
}

TEST(BadInput, ASingularCalibration) {
  const char* const bad[] = {
      "P0: 0 0 160 0 0 0 120 0 0 0 1 0\nP1: 0 0 160 0 0 0 120 0 0 0 1 0\n",            // no focal length
      "P0: 350 0 160 0 0 350 120 0 0 0 1 0\nP1: 350 0 160 0 0 350 120 0 0 0 1 0\n",    // no baseline
      "P0: nan 0 160 0 0 nan 120 0 0 0 1 0\nP1: nan 0 160 -42 0 nan 120 0 0 0 1 0\n",  // no numbers
  };
  for (const char* text : bad) {
    expect_refused({"replay", made_recording(), "--calibration", file_with("calib.txt", text)}, 1, "calib.txt");
  }
}

TEST(BadInput, AnUnknownKeyInTheConfigurationIsNamedWithFileAndLine) {
  const std::string config = file_with("c.yaml", "stereo:\n  window: 9\n  windw: 9\n");
  expect_refused({"replay", "sim", "--config", config}, 1, config + ":3");
  expect_refused({"replay", "sim", "--config", config}, 1, "windw");
}

TEST(BadInput, AConfigurationThatIsMissingOrOutOfRange) {
  expect_refused({"replay", "sim", "--config", "/nowhere/c.yaml"}, 1, "/nowhere/c.yaml");
  const std::string config = file_with("c.yaml", "stereo:\n  window: 99\n");
  expect_refused({"replay", "sim", "--config", config}, 1, config + ":2");
}

TEST(BadInput, PlacesThatCannotBeWrittenShowBeforeTheReplay) {
  const std::string recording = made_recording();
  for (const char* option : {"--trajectory", "--stats", "--plot"}) {
    expect_refused({"replay", recording, option, "/nowhere/file"}, 1, "/nowhere/file");
  }
}

TEST(BadInput, AFullDiskIsAnError) {
  expect_refused({"replay", made_recording(), "--trajectory", "/dev/full"}, 1, "/dev/full");
  expect_refused({"replay", made_recording(), "--stats", "/dev/full"}, 1, "/dev/full");
}

TEST(BadInput, PairsBeyondTheRecording) { expect_refused({"replay", made_recording(), "--first", "100"}, 1, "0 to 5"); }

TEST(BadInput, AMaskOfAnotherSize) {
  const std::string recording = made_recording();
  cv::imwrite(recording + "/mask_left.png", cv::Mat(100, 100, CV_8UC1, cv::Scalar(255)));
  expect_refused({"replay", recording}, 1, "mask_left.png");
}

TEST(BadInput, AReferenceThatDoesNotFit) {
  const std::string reference = file_with("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_refused({"replay", made_recording(), "--reference", reference}, 1, reference);
}

TEST(BadInput, NoLcmRouteIsAWarningAndTheReplayGoesOn) {
  // A chroot allows no namespace of users, and root needs none.
  const std::vector<std::string> no_network = ::geteuid() == 0 ? std::vector<std::string>{"unshare", "--net"}
                                                               : std::vector<std::string>{"unshare", "--user", "--net"};
  for (const std::vector<std::string>& before : {no_network, {}}) {
    std::vector<std::string> command = before;
    const std::string trajectory = scratch_dir() + "/t.txt";
    // Without a network there is no route; with one, this address is none to send to.
    const std::string url = before.empty() ? "udpm://nonsense" : "udpm://239.255.76.67:7667?ttl=0";
    command.insert(command.end(),
                   {binary("cliquevo"), "replay", made_recording(), "--lcm", url, "--trajectory", trajectory});
    const Finished done = run(command);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.err.rfind("warning: ", 0), 0u) << done.err;
    EXPECT_EQ(lines_of(done.err).size(), 1u) << done.err;
    EXPECT_EQ(lines_of(read_file(trajectory)).size(), 6u);
  }
}

TEST(RecordingWithoutTimes, IsPlayedByEveryCommandWithTheRateThatItsErrorAsksFor) {
  const std::string recording = made_recording();
  std::filesystem::remove(recording + "/times.txt");
  expect_refused({"info", recording}, 1, "--rate");
  const Finished done = run({binary("cliquevo"), "info", recording, "--rate", "25", "--json"});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("\"rate_hz\": 25.0"), std::string::npos) << done.out;
}

TEST(WrongUsage, IsExitCode2AndOneLine) {
  const std::string recording = made_recording();
  expect_refused({}, 2, "cliquevo --help");
  expect_refused({"nonsense"}, 2, "nonsense");
  expect_refused({"replay"}, 2, "SOURCE");
  expect_refused({"replay", recording, "--nonsense"}, 2, "--nonsense");
  expect_refused({"replay", recording, "--format", "csv"}, 2, "--format");
  expect_refused({"replay", recording, "--speed", "fast"}, 2, "--speed");
  expect_refused({"replay", recording, "--speed", "-1"}, 2, "--speed");
  expect_refused({"replay", recording, "--every", "0"}, 2, "--every");
  expect_refused({"replay", recording, "--first", "x"}, 2, "--first");
  expect_refused({"replay", recording, "--first", "4", "--last", "2"}, 2, "--last");
  expect_refused({"replay", recording, "--rate", "0"}, 2, "--rate");
  expect_refused({"info", recording, "--rate", "0"}, 2, "--rate");
  expect_refused({"replay", "sim:nonsense=1"}, 2, "nonsense");
  expect_refused({"replay", "sim:frames=-1"}, 2, "frames");
  expect_refused({"replay", "sim", "--calibration", "calib.txt"}, 2, "sim");
  expect_refused({"eval", "--reference", "a.txt"}, 2, "--estimate");
  for (const char* length : {"0", "nan", "inf", "-5", "1e200", "10,nan", "x"}) {
    expect_refused({"eval", "--reference", "a", "--estimate", "b", "--lengths", length}, 2, "--lengths");
  }
  expect_refused({"eval", "--reference", "a", "--estimate", "b", "--tolerance", "nan"}, 2, "--tolerance");
  expect_refused({"eval", "--reference", "a", "--estimate", "b", "--sample-period", "nan"}, 2, "--sample-period");
  expect_refused({"replay", recording, "--rate", "nan"}, 2, "--rate");
  expect_refused({"replay", recording, "--pair-tolerance", "nan"}, 2, "--pair-tolerance");
  expect_refused({"replay", "sim", "--channel", "X"}, 2, "--channel");
  expect_refused({"disparity", "a.png", "b.png"}, 2, "--out");
  expect_refused({"disparity", "a.png", "b.png", "--out", "c.png", "--max-disparity", "0"}, 2, "--max-disparity");
}

TEST(Help, TellsEveryCommandsOptionsWithExamples) {
  for (const char* command : {"replay", "eval", "disparity"}) {
    const Finished done = run({binary("cliquevo"), command, "--help"});
    EXPECT_EQ(done.exit_code, 0);
    EXPECT_NE(done.out.find("Example"), std::string::npos) << command;
    EXPECT_NE(run({binary("cliquevo"), "--help"}).out.find(command), std::string::npos);
  }
  const std::string help = run({binary("cliquevo"), "replay", "--help"}).out;
  for (const char* option :
       {"--calibration", "--config", "--trajectory", "--format", "--stats", "--plot", "--speed", "--rate", "--first",
        "--last", "--every", "--pair-tolerance", "--lcm", "--strict", "--channel", "--side-by-side", "--swap-eyes"}) {
    EXPECT_NE(help.find(option), std::string::npos) << option;
  }
}

}  // namespace
}  // namespace cliquevo::test
