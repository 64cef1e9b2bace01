// SPDX-License-Identifier: BSD-3-Clause
// The guide says what is missing until it is there, and takes nothing that is blurred, moving or known.
#include "tools/calibrate/guide.h"

#include <cstdio>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "drivers/board_calibration/accuracy.h"
#include "drivers/simulator/board_course.h"
#include "tools/calibrate/sharpness.h"

namespace cliquevo::tools {
namespace {

using calibration::Side;
using calibration::View;
using drivers::sim::BoardCourse;
using drivers::sim::BoardPattern;
using drivers::sim::SimulatedLens;

// What a board held in one place after the other shows: corners alone, with noise.
class Holder {
 public:
  explicit Holder(const std::string& options)
      : options_(*drivers::parse_simulator_options("board_hold_s=0,frames=200," + options)),
        board(*calibration::parse_board(options_.board)),
        rig(drivers::sim::board_rig(options_)),
        left_(rig.left),
        right_(rig.right),
        course_(*BoardCourse::make(options_, *BoardPattern::make(board), rig)) {}

  Look look(int place) {
    const RigidTransform T = course_.T_left_board(place / options_.rate_hz);
    return look_from(T);
  }
  View exact(int place) {
    const double noise_px = std::exchange(noise_px_, 0.0);
    View out = look(place).view;
    noise_px_ = noise_px;
    return out;
  }
  Look look_from(const RigidTransform& T) {
    Look out;
    out.view.name = "a place";
    out.view.left = seen(left_, T);
    out.view.right = seen(right_, rig.T_right_left * T);
    out.edge_px = {2.5, 2.5};
    out.speed_px_s = 0.0;
    return out;
  }

 private:
  std::vector<calibration::SeenCorner> seen(const SimulatedLens& lens, const RigidTransform& T) {
    std::vector<calibration::SeenCorner> out;
    for (int id = 0; id < board.corner_count(); ++id) {
      if (!lens.shows(T * board.corner(id))) return {};
      const Eigen::Vector2d noise(normal_(bits_), normal_(bits_));
      out.push_back({id, *lens.project(T * board.corner(id)) + noise_px_ * noise});
    }
    return out;
  }

  const drivers::SimulatorOptions options_;
  double noise_px_ = 0.006;  // of a corner in one picture of the simulator

 public:
  const calibration::Board board;
  const StereoCalibration rig;

 private:
  SimulatedLens left_, right_;
  BoardCourse course_;
  std::mt19937_64 bits_{5};
  std::normal_distribution<double> normal_;
};

constexpr const char* kRig = "board=chessboard:9x6:0.03,raw=on,width=512,height=384";

TEST(Guide, SaysEnoughWhenTheRigIsKnownWellEnough) {
  Holder holder(kRig);
  Guide guide(holder.board, 512, 384, {});
  int looks = 0;
  while (!guide.enough() && looks < 200) {
    const Look look = holder.look(looks++);
    if (guide.judge(look) == Refusal::none) guide.take(look.view);
  }
  ASSERT_TRUE(guide.enough()) << guide.next();
  std::printf("enough with %zu views of %d: %s\n", guide.views().size(), looks, guide.estimate().c_str());
  EXPECT_LT(guide.views().size(), 60U);
  EXPECT_EQ(guide.advice({}, Refusal::none), "enough");
  calibration::SolveOptions options;
  options.model = "radtan";
  const auto solution = calibration::solve(holder.board, guide.views(), 512, 384, options);
  ASSERT_TRUE(solution.ok());
  EXPECT_NEAR(solution->rig().T_right_left.t.norm(), holder.rig.T_right_left.t.norm(), 3e-4);
  EXPECT_NEAR(solution->rig().left(0), holder.rig.left.fx_px, 2.0);
}

TEST(Guide, AsksForWhatIsMissing) {
  Holder holder(kRig);
  Guide guide(holder.board, 512, 384, {});
  Look nothing;
  EXPECT_EQ(guide.judge(nothing), Refusal::no_board);
  EXPECT_NE(guide.advice(nothing, Refusal::no_board).find("the board is not seen"), std::string::npos);
  // Held flat, far away, in the middle of the right half: all else is missing.
  for (int k = 0; k < 3; ++k) {
    RigidTransform T;
    T.t = Eigen::Vector3d(0.03 * k, -0.05, 1.2) + Eigen::Vector3d(0.1, 0.0, 0.0);
    guide.take(holder.look_from(T).view);
  }
  const std::string wanted = guide.next();
  EXPECT_NE(wanted.find("left"), std::string::npos) << wanted;
  EXPECT_NE(wanted.find("closer"), std::string::npos) << wanted;
  EXPECT_NE(wanted.find("tilt its"), std::string::npos) << wanted;
  EXPECT_LT(guide.bars()[3].share, 0.1) << "tilt";
  // Its right side away: that is seen as such.
  RigidTransform tilted;
  tilted.R = so3_exp({0.0, -0.5, 0.0});
  tilted.t = Eigen::Vector3d(0.0, -0.05, 1.0);
  ASSERT_GT((tilted * Eigen::Vector3d(0.2, 0.0, 0.0)).z(), 1.0);
  const double before = guide.bars()[3].share;
  guide.take(holder.look_from(tilted).view);
  guide.take(holder.look_from(tilted).view);
  EXPECT_NEAR(guide.bars()[3].share, before + 0.25, 1e-9);
  EXPECT_EQ(guide.next().find("tilt its right side away"), std::string::npos) << guide.next();
  guide.drop_last();
  EXPECT_NEAR(guide.bars()[3].share, before + 0.125, 1e-9);
}

TEST(Guide, RefusesWhatMovesIsSkewedIsBlurredOrIsThereAlready) {
  Holder holder(kRig);
  Guide guide(holder.board, 512, 384, {});
  Look look = holder.look(0);
  look.speed_px_s.reset();
  EXPECT_EQ(guide.judge(look), Refusal::moving) << "it was not seen before";
  look.speed_px_s = 60.0;
  EXPECT_EQ(guide.judge(look), Refusal::moving);
  look.speed_px_s = 20.0;
  look.skew_s = 0.012;
  EXPECT_EQ(guide.judge(look), Refusal::skewed) << "a quarter of a pixel between the exposures";
  EXPECT_NE(guide.advice(look, Refusal::skewed).find("12.0 ms apart"), std::string::npos);
  look.skew_s = 0.002;
  EXPECT_EQ(guide.judge(look), Refusal::none);
  guide.take(look.view);
  EXPECT_EQ(guide.judge(holder.look(0)), Refusal::alike);
  for (int k = 1; k < 12; ++k) guide.judge(holder.look(k));
  Look blurred = holder.look(13);
  blurred.edge_px[1] = 4.5;
  EXPECT_EQ(guide.judge(blurred), Refusal::blurred) << "sharp edges are 2.5 px wide here";
}

TEST(Guide, PairsOfOnePlaceMakeItsViewMoreCertain) {
  Holder holder(kRig);
  const View exact = holder.exact(0);
  const auto rms_px = [&](const View& view) {
    double squared = 0.0;
    for (std::size_t i = 0; i < view.left.size(); ++i) squared += (view.left[i].px - exact.left[i].px).squaredNorm();
    return std::sqrt(squared / static_cast<double>(view.left.size()));
  };
  Guide guide(holder.board, 512, 384, {});
  const Look first = holder.look(0);
  ASSERT_EQ(guide.judge(first), Refusal::none);
  guide.take(first.view);
  const double once_px = rms_px(guide.views()[0]);
  for (int k = 0; k < 15; ++k) {
    const Look again = holder.look(0);
    const Refusal refusal = guide.judge(again);
    ASSERT_TRUE(guide.improves_last(again, refusal));
    guide.improve_last(again.view);
  }
  EXPECT_EQ(guide.views().size(), 1U) << "it is one view";
  EXPECT_LT(rms_px(guide.views()[0]), 0.35 * once_px);
  const Look elsewhere = holder.look(1);
  EXPECT_FALSE(guide.improves_last(elsewhere, guide.judge(elsewhere)));
  Look shifted = holder.look(0);
  for (auto& corner : shifted.view.left) corner.px.x() += 2.0;
  EXPECT_FALSE(guide.improves_last(shifted, Refusal::alike)) << "two pixels are another place";
  EXPECT_FALSE(guide.improves_last(holder.look(0), Refusal::moving));
  Look in_part = holder.look(0);
  in_part.view.right.resize(40);
  EXPECT_FALSE(guide.improves_last(in_part, Refusal::alike)) << "it would lose corners";
}

TEST(Guide, EdgesThatAreBlurredAreWide) {
  const auto width_with = [](double defocus_px, double vibration_px) {
    const std::string more =
        ",defocus_px=" + std::to_string(defocus_px) + ",vibration_px=" + std::to_string(vibration_px);
    Holder holder(kRig);
    auto source = drivers::open_simulator(
        *drivers::parse_simulator_options(std::string(kRig) + ",board_hold_s=0,frames=1" + more));
    drivers::StereoPair pair;
    EXPECT_TRUE(*(*source)->next(pair));
    return edge_width_px(pair.left.cview(), holder.look(0).view.left);
  };
  const double sharp = width_with(0.0, 0.0), soft = width_with(1.0, 0.0), softer = width_with(2.0, 0.0);
  std::printf("edges %.2f px wide, with a blur of 1 px %.2f, of 2 px %.2f\n", sharp, soft, softer);
  EXPECT_LT(sharp, 3.5);
  EXPECT_NEAR(soft - sharp, 1.5, 0.9);
  EXPECT_GT(softer, soft + 2.0);
}

}  // namespace
}  // namespace cliquevo::tools
