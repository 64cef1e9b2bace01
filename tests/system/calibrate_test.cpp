// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo calibrate` as a user runs it: on a real board, on what is no board, and on a drive without one.
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "drivers/calibration/writers.h"
#include "drivers/simulator.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

constexpr const char* kBoard = "chessboard:9x6:0.02423";

double value(const json& result, const char* name) { return result["parameters"][name]["value"].get<double>(); }
double sigma(const json& result, const char* name) { return result["parameters"][name]["sigma"].get<double>(); }

TEST(Calibrate, ARealBoardGivesTheRigWithItsUncertainty) {
  CLIQUEVO_NEEDS_DATA("chessboard");
  const std::string out = scratch_dir() + "/rig.yaml";
  const std::string page = scratch_dir() + "/rig.html";
  const Finished done = run({binary("cliquevo"), "calibrate", data_dir() + "/chessboard", "--board", kBoard, "--out",
                             out, "--report", page, "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const json result = json::parse(done.out);
  EXPECT_LE(result["rms_px"].get<double>(), 0.25);
  EXPECT_EQ(result["views_used"], 29);
  for (const char* name : {"left.fx_px", "left.fy_px", "right.fx_px", "right.fy_px"}) {
    EXPECT_NEAR(value(result, name), 463.0, 1.5) << name;
    EXPECT_GT(sigma(result, name), 0.1) << name;
    EXPECT_LT(sigma(result, name), 1.5) << name;
  }
  EXPECT_NEAR(result["baseline_m"].get<double>(), 0.094, 0.0005);
  EXPECT_LT(result["held_out"]["row_rms_px"].get<double>(), 0.35);
  EXPECT_NE(read_file(page).find("<svg"), std::string::npos);
  // Held against itself it is off by nothing.
  const Finished again = run({binary("cliquevo"), "calibrate", data_dir() + "/chessboard", "--board", kBoard, "--out",
                              scratch_dir() + "/again.yaml", "--compare", out, "--json"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const json compared = json::parse(again.out)["compared"];
  EXPECT_LT(compared["rows_px"].get<double>(), 0.01);
  EXPECT_LT(std::abs(compared["depth"][1]["sigmas"].get<double>()), 0.01);
}

// No image shows how large a board is: the rig is as much too large, and that is said.
TEST(Calibrate, AWrongSizeOfTheBoardIsInNoErrorAndTheResultSaysSo) {
  CLIQUEVO_NEEDS_DATA("chessboard");
  const auto with_size = [](const std::string& size_m) {
    const Finished done = run({binary("cliquevo"), "calibrate", data_dir() + "/chessboard", "--board",
                               "chessboard:9x6:" + size_m, "--model", "radtan", "--out", scratch_dir() + "/rig.yaml"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_NE(done.out.find("its size is as named: no image can show it"), std::string::npos) << done.out;
    const auto line_with = [&](const std::string& words) {
      const std::size_t at = done.out.find(words);
      return done.out.substr(at, done.out.find('\n', at) - at);
    };
    const std::string rig = line_with("baseline ");
    return std::pair{std::stod(rig.substr(9)), line_with("errors ")};
  };
  const auto right = with_size("0.02423"), wrong = with_size("0.04846");
  EXPECT_NEAR(wrong.first, 2.0 * right.first, 0.002);
  EXPECT_EQ(wrong.second, right.second);
}

TEST(Calibrate, WhatCannotBeCalibratedIsOneLineThatSaysWhatToDo) {
  CLIQUEVO_NEEDS_DATA("chessboard");
  const std::string folder = data_dir() + "/chessboard";
  const std::string out = scratch_dir() + "/rig.yaml";
  const auto refused = [&](std::vector<std::string> arguments, int exit_code, const std::string& words) {
    std::vector<std::string> command{binary("cliquevo"), "calibrate"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    command.insert(command.end(), {"--out", out});
    const Finished done = run(command);
    EXPECT_EQ(done.exit_code, exit_code) << done.err;
    ASSERT_FALSE(lines_of(done.err).empty());
    EXPECT_NE(lines_of(done.err).back().find(words), std::string::npos) << done.err;
    EXPECT_FALSE(std::ifstream(out).good()) << "nothing is written";
  };
  refused({folder, "--board", "chessboard:8x5:0.024", "--max-views", "5"}, 1, "9x6 corners are seen, 8x5 were named");
  refused({folder, "--board", kBoard, "--swap-eyes"}, 1, "exchanged");
  refused({folder, "--board", "chessboard:9x6"}, 2, "measure it");
  refused({folder, "--board", "checkerboard:9x6:0.02"}, 2, "chessboard, charuco, aprilgrid or circles");
  refused({folder}, 2, "--board");
  refused({scratch_dir() + "/none", "--board", kBoard}, 1, "/none");
  refused({"sim:board=chessboard:9x6:0.03,frames=4,board_hold_s=0", "--board", "charuco:9x6:0.03"}, 1,
          "a chessboard with 9x6 corners is seen");
  refused({"sim:board=charuco:9x6:0.03,frames=4,board_hold_s=0", "--board", "chessboard:9x6:0.03"}, 1,
          "markers of a charuco board are seen");
  refused({"sim:board=chessboard:9x6:0.03,frames=30,fault=covered,board_hold_s=0", "--board", "chessboard:9x6:0.03"}, 1,
          "the left camera never saw the board");
  refused({"sim:board=chessboard:9x6:0.03,frames=4,board_hold_s=0", "--board", "chessboard:9x6:0.03"}, 1,
          "too few views");
  refused({"sim:board=chessboard:9x6", "--board", kBoard}, 2, "measure it");
  refused({"sim:lens=rational", "--board", kBoard}, 2, "name a board");
  refused({"sim:frames=8", "--board", kBoard}, 1, "no chessboard:9x6:0.02423 found in 8 pairs");
  refused({"sim:frames=8", "--from-driving"}, 1, "shows too little");
}

// A board that is moved before simulated cameras: the command finds what they are.
TEST(Calibrate, ASimulatedBoardGivesTheRigThatIsThere) {
  const std::string source = "sim:board=charuco:9x6:0.03,raw=on,frames=36,board_hold_s=0";
  const std::string out = scratch_dir() + "/rig.yaml";
  const Finished done =
      run({binary("cliquevo"), "calibrate", source, "--board", "charuco:9x6:0.03", "--out", out, "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const json result = json::parse(done.out);
  EXPECT_GT(result["views_used"], 25);
  EXPECT_NEAR(result["baseline_m"].get<double>(), 0.12, 3.0 * result["baseline_sigma_m"].get<double>() + 1e-5);
  EXPECT_NEAR(value(result, "left.fx_px"), 0.9914 * 560.0, 3.0 * sigma(result, "left.fx_px"));
  EXPECT_NEAR(value(result, "right.fy_px"), 0.9918 * 560.0, 3.0 * sigma(result, "right.fy_px"));
}

TEST(Calibrate, CtrlCOfAGuidedRunKeepsWhatWasCollected) {
  const std::string out = scratch_dir() + "/rig.yaml", said = scratch_dir() + "/said";
  const std::string command =
      "exec '" + binary("cliquevo") +
      "' calibrate sim:board=chessboard:9x6:0.03,raw=on,frames=100000,board_hold_s=0.2,board_move_s=0 --board "
      "chessboard:9x6:0.03 --model radtan --page --port 0 --out '" +
      out + "' 2> '" + said + "'";
  Subprocess guided({"sh", "-c", command});
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  while (read_file(said).find("\n9 views;") == std::string::npos && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  guided.send(SIGINT);
  const Finished done = guided.wait();
  const std::string err = read_file(said);
  EXPECT_EQ(done.exit_code, 0) << err;
  EXPECT_NE(err.find("/calibrate.html\n"), std::string::npos) << err;
  EXPECT_NE(err.find("next: "), std::string::npos) << err;
  EXPECT_EQ(err.find("; enough"), std::string::npos) << err;
  EXPECT_NE(done.out.find("written"), std::string::npos) << done.out;
  EXPECT_TRUE(std::ifstream(out).good());
}

TEST(Calibrate, ADriveCorrectsARightCameraThatIsTurnedAndLeavesAGoodRigAlone) {
  const std::string out = scratch_dir() + "/rig.yaml";
  const std::string course = "sim:frames=120,width=384,height=288,focal_px=420";
  const auto driven = [&](const std::string& source) {
    const Finished done = run({binary("cliquevo"), "calibrate", source, "--from-driving", "--out", out, "--json"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return json::parse(done.out);
  };
  const json good = driven(course);
  EXPECT_FALSE(good["changed"].get<bool>());
  const double good_end_pct = good["runs"].back()["end_pct"].get<double>();
  const json turned = driven(course + ",misalign_right_deg=0.1:0.2:-0.1");
  EXPECT_TRUE(turned["changed"].get<bool>());
  EXPECT_NEAR(turned["turned_deg"][0].get<double>(), 0.1, 0.01);
  EXPECT_NEAR(turned["turned_deg"][1].get<double>(), 0.2, 0.01);
  EXPECT_NEAR(turned["turned_deg"][2].get<double>(), -0.1, 0.03);
  EXPECT_GT(turned["runs"].front()["end_pct"].get<double>(), 1.0) << "before";
  EXPECT_LT(turned["runs"].back()["end_pct"].get<double>(), 1.2 * good_end_pct + 0.15) << "after";
}

// A raw drive whose calibration has the right camera's focal lengths wrong.
TEST(Calibrate, ADriveFindsTheRatioOfTheFocalLengths) {
  const std::string folder = scratch_dir(), drive = folder + "/drive", wrong = folder + "/wrong.yaml",
                    corrected = folder + "/corrected.yaml";
  constexpr double kRatio = 1.004;
  const Finished made = run({binary("cliquevo"), "simulate", "--out", drive, "--raw", "--frames", "150", "--width",
                             "384", "--height", "288", "--focal-px", "420"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto source =
      drivers::open_simulator(*drivers::parse_simulator_options("raw=on,width=384,height=288,focal_px=420"));
  ASSERT_TRUE(source.ok());
  const auto write = [](StereoCalibration calibration, double ratio, const std::string& path) {
    calibration.right.fx_px *= ratio;
    calibration.right.fy_px *= ratio;
    calibration.prescribed.reset();
    const auto files = drivers::find_calibration_writer("opencv")->write(calibration, path);
    ASSERT_TRUE(files.ok());
    for (const auto& file : *files) std::ofstream(file.path) << file.text;
  };
  const StereoCalibration truth = (*source)->info().calibration;
  write(truth, kRatio, wrong);
  const auto driven = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command{binary("cliquevo"), "calibrate", drive, "--from-driving", "--out",
                                     corrected,          "--json"};
    command.insert(command.end(), more.begin(), more.end());
    const Finished done = run(command);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return json::parse(done.out);
  };
  const auto drift_pct = [&](const std::vector<std::string>& more) {
    const std::string poses = folder + "/poses.txt";
    std::vector<std::string> command{binary("cliquevo"), "replay", drive, "--trajectory", poses};
    command.insert(command.end(), more.begin(), more.end());
    EXPECT_EQ(run(command).exit_code, 0);
    const Finished judged = run({binary("cliquevo"), "eval", "--reference", drive + "/poses.txt", "--estimate", poses,
                                 "--lengths", "5,10", "--json"});
    return json::parse(judged.out)["t_err_pct"].get<double>();
  };
  const json good = driven({});
  EXPECT_FALSE(good["changed"].get<bool>()) << good;
  const double with_truth = drift_pct({}), with_wrong = drift_pct({"--calibration", wrong});
  const json found = driven({"--calibration", wrong});
  const double with_found = drift_pct({"--calibration", corrected});
  std::printf(
      "ratio %.5f +- %.5f of %.5f; drift %.4f %% with the true calibration, %.4f %% with the wrong one, %.4f %% "
      "corrected\n",
      found["focal_ratio"].get<double>(), found["focal_ratio_sigma"].get<double>(), 1.0 / kRatio, with_truth,
      with_wrong, with_found);
  EXPECT_TRUE(found["changed"].get<bool>());
  EXPECT_NEAR(found["focal_ratio"].get<double>(), 1.0 / kRatio, 3.0 * found["focal_ratio_sigma"].get<double>());
  EXPECT_LE(with_found, 1.2 * with_truth);
}

TEST(Calibrate, ABoardIsPrintedAtTrueScale) {
  const std::string svg = scratch_dir() + "/board.svg";
  const Finished done =
      run({binary("cliquevo"), "calibrate", "--make-board", "--board", "charuco:9x6:0.03", "--out", svg});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  // 9 x 30 mm and a border of 15 mm on each side, in points of 1/72 inch.
  EXPECT_NE(read_file(svg).find("width=\"850.393701pt\""), std::string::npos) << read_file(svg).substr(0, 400);
  const std::string pdf = scratch_dir() + "/board.pdf";
  ASSERT_EQ(
      run({binary("cliquevo"), "calibrate", "--make-board", "--board", "aprilgrid:6x6:0.05", "--out", pdf}).exit_code,
      0);
  EXPECT_EQ(read_file(pdf).substr(0, 5), "%PDF-");
  EXPECT_EQ(run({binary("cliquevo"), "calibrate", "--make-board", "--board", "aprilgrid:6x6:0.05", "--out", "/x/b.png"})
                .exit_code,
            1);
}

}  // namespace
}  // namespace cliquevo::test
