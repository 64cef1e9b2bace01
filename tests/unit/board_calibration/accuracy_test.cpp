// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/accuracy.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "drivers/board_calibration/residual_field.h"
#include "tests/unit/board_calibration/made_rig.h"

namespace cliquevo::calibration {
namespace {

Solution solved(const MadeRig& made, const char* model) {
  SolveOptions options;
  options.model = model;
  auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, options);
  EXPECT_TRUE(solution.ok());
  return std::move(*solution);
}

TEST(Accuracy, DepthErrorsOfManyCalibrationsAreAsLargeAsEachOfThemStates) {
  double squared = 0.0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < std::min<std::uint64_t>(12, kRigs); ++seed) {
    if (seed % 4 == 3) continue;
    const MadeRig made = make_rig(seed, 20, 0.1);
    const Solution s = solved(made, made.rig.model->name);
    // The truth, held against the calibration as another one is.
    const Movement m = movement(s.rig(), s.adjusted.covariance, made.rig.calibration());
    for (const double sigmas : m.depth_sigmas) {
      EXPECT_LT(std::abs(sigmas), 4.0) << seed;
      squared += sigmas * sigmas;
      ++count;
    }
  }
  EXPECT_GT(squared / count, kRigs == 20 ? 0.3 : 0.01);
  EXPECT_LT(squared / count, kRigs == 20 ? 2.5 : 6.0);
}

TEST(Accuracy, DepthIsTheLessCertainTheFartherAndDriftIsItsShare) {
  const MadeRig made = make_rig(0, 20, 0.1);
  const Solution s = solved(made, "radtan");
  const Accuracy a = accuracy(s.rig(), s.adjusted.covariance);
  EXPECT_GT(a.depth_m[1], 2.0 * a.depth_m[0]);
  EXPECT_GT(a.depth_m[2], 2.0 * a.depth_m[1]);
  EXPECT_LE(a.drift_percent, 100.0 * a.depth_m[0] / kJudgedDepths_m[0] * 1.001);
  EXPECT_GT(a.rotation_deg, 0.0);
  EXPECT_GT(a.baseline_m, 0.0);
}

TEST(Accuracy, ATurnedCameraIsSeenInMovement) {
  const MadeRig made = make_rig(1, 20, 0.1);
  const Solution s = solved(made, "radtan");
  StereoCalibration turned = s.rig().calibration();
  turned.T_right_left.R = so3_exp({0.0035, 0.0, 0.0}) * turned.T_right_left.R;  // 0.2 degrees
  const Movement m = movement(s.rig(), s.adjusted.covariance, turned);
  EXPECT_NEAR(m.rotation_deg, 0.2, 0.01);
  EXPECT_NEAR(m.rows_px, 0.0035 * s.rig().left(1), 0.5);
}

TEST(ResidualField, StructureIsLeftOverWhereTheLensModelIsTooSimple) {
  MadeRig made = make_rig(0, kRigs == 20 ? 40 : 20, 0.05);
  // A lens that plumb-bob without k3 cannot follow.
  const LensModel& fisheye = *find_lens_model("equidistant");
  for (std::size_t v = 0; v < made.views.size(); ++v) {
    for (const Side side : {Side::left, Side::right}) {
      for (SeenCorner& corner : made.views[v].of(side)) {
        Eigen::Vector3d p = made.T_left_board[v] * made.board.corner(corner.id);
        if (side == Side::right) p = made.rig.T_right_left * p;
        LensVector lens = LensVector::Zero();
        lens.head<4>() = made.rig.lens(side).head<4>();
        lens.tail<8>().head<4>() << 0.3, 0.6, -0.9, 0.4;
        const Eigen::Vector2d noise =
            corner.px - made.exact[v].of(side)[static_cast<std::size_t>(&corner - made.views[v].of(side).data())].px;
        corner.px = project_with_derivatives(fisheye, lens, p).px + noise;
      }
    }
  }
  const Solution wrong = solved(made, "radtan");
  const Solution right = solved(made, "equidistant");
  const double left_over = residual_field(made.board, wrong, Side::left).structure_px;
  EXPECT_GT(left_over, 3.0 * residual_field(made.board, right, Side::left).structure_px + 0.005);
}

}  // namespace
}  // namespace cliquevo::calibration
