// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "drivers/board_calibration/held_out.h"
#include "drivers/board_calibration/start.h"

namespace cliquevo::calibration {

namespace {

constexpr std::size_t kLeastViews = 5;
constexpr std::size_t kLeastCornersOfView = 6;
constexpr double kLeastTilt_rad = 0.15;  // between the boards of the views: less fixes no focal length
constexpr double kOutlierSigmas = 5.0;   // of one coordinate
constexpr double kLeastOutlierSigma_px =
    0.01;                              // corners that are better than that differ in what they are off by all the same
constexpr double kMostOutliers = 0.3;  // of a view's corners: then the view is no view
constexpr double kMostShift = 0.25;    // of the rig between two views, as a share of the way to the board
constexpr double kMostTurn_rad = 0.35;
constexpr double kClearlyBetter = 0.99;  // on views held out: a model with more parameters must be worth it

// One side's corners, as View::left.
std::vector<View> one_side(const std::vector<View>& views, Side side) {
  std::vector<View> out;
  out.reserve(views.size());
  for (const View& view : views) out.push_back({view.name, view.of(side), {}});
  return out;
}

double largest_tilt(const std::vector<RigidTransform>& poses, const std::vector<View>& views) {
  double least = 1.0;
  for (std::size_t a = 0; a < poses.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (views[a].left.empty() || views[b].left.empty()) continue;
      least = std::min(least, std::abs(poses[a].R.col(2).dot(poses[b].R.col(2))));
    }
  }
  return std::acos(std::clamp(least, -1.0, 1.0));
}

// A chessboard and a grid of dots look the same turned by half.
bool is_symmetric(const Board& board) {
  return board.kind == BoardKind::chessboard || board.kind == BoardKind::circles;
}

void turn_by_half(const Board& board, std::vector<SeenCorner>& corners) {
  for (SeenCorner& corner : corners) corner.id = board.corner_count() - 1 - corner.id;
}

// Pose of the board as if its corners were counted from the other end.
RigidTransform turned_by_half(const Board& board, const RigidTransform& T) {
  RigidTransform half;
  half.R = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal();
  half.t << 2.0 * board.middle(), 0.0;
  return T * half;
}

struct RigPose {
  RigidTransform T_right_left;
  int agreeing = 0;
};

bool agree(const RigidTransform& a, const RigidTransform& b, double distance_m) {
  return (a.inverse() * b).angle() < kMostTurn_rad && (a.t - b.t).norm() < kMostShift * distance_m;
}

// The rig that most views show. Views whose right corners are counted from the other end are turned.
std::optional<RigPose> find_rig(const Board& board, std::vector<View>& views, const OneCamera& left, OneCamera& right) {
  struct Candidate {
    std::size_t view;
    bool turned;
    RigidTransform T_right_left;
    double distance_m;
  };
  std::vector<Candidate> all;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (views[v].left.empty() || views[v].right.empty()) continue;
    const RigidTransform T_board_left = left.T_camera_board[v].inverse();
    const double distance_m = left.T_camera_board[v].t.norm();
    all.push_back({v, false, right.T_camera_board[v] * T_board_left, distance_m});
    if (!is_symmetric(board)) continue;
    all.push_back({v, true, turned_by_half(board, right.T_camera_board[v]) * T_board_left, distance_m});
  }
  RigPose best;
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& centre : all) {
    int agreeing = 0;
    double apart = 0.0;
    for (const Candidate& other : all) {
      if (!agree(centre.T_right_left, other.T_right_left, other.distance_m)) continue;
      ++agreeing;
      apart += (centre.T_right_left.inverse() * other.T_right_left).angle();
    }
    if (agreeing < best.agreeing || (agreeing == best.agreeing && apart >= least)) continue;
    best = {centre.T_right_left, agreeing};
    least = apart;
  }
  if (best.agreeing == 0) return std::nullopt;
  for (const Candidate& c : all) {
    if (!c.turned || !agree(best.T_right_left, c.T_right_left, c.distance_m)) continue;
    turn_by_half(board, views[c.view].right);
    right.T_camera_board[c.view] = turned_by_half(board, right.T_camera_board[c.view]);
  }
  return best;
}

SharedMask everything(const LensModel& model, const SolveOptions& options) {
  SharedMask mask{};
  for (const std::size_t first : {std::size_t{0}, std::size_t{kFirstOfRight}}) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(model.size()); ++i) mask[first + i] = true;
    if (options.square_pixels) mask[first + 1] = false;
  }
  for (int i = kFirstOfPose; i < kShared; ++i) mask[static_cast<std::size_t>(i)] = true;
  return mask;
}

AdjustmentOptions options_of(const LensModel& model, const SolveOptions& options, bool robust) {
  AdjustmentOptions out;
  out.estimated = everything(model, options);
  out.square_pixels = options.square_pixels;
  out.robust = robust;
  return out;
}

// Takes out corners far from where the rest puts them, and views that are mostly such; true: something was.
bool drop_outliers(const Board& board, Solution& s, std::vector<RigidTransform>& poses) {
  std::vector<double> lengths;
  for (std::size_t v = 0; v < s.views.size(); ++v) {
    for (const Side side : {Side::left, Side::right}) {
      for (const auto& e : residuals(board, s.rig(), poses[v], s.views[v], side)) lengths.push_back(e.norm());
    }
  }
  if (lengths.empty()) return false;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  constexpr double kMedianLength = 1.1774;  // of a two-dimensional normal vector, in sigmas
  const double most = kOutlierSigmas * std::max(kLeastOutlierSigma_px, *middle / kMedianLength);
  bool dropped = false;
  std::vector<View> views;
  std::vector<RigidTransform> kept_poses;
  for (std::size_t v = 0; v < s.views.size(); ++v) {
    View kept{s.views[v].name, {}, {}};
    std::vector<DroppedCorner> out;
    for (const Side side : {Side::left, Side::right}) {
      const auto errors = residuals(board, s.rig(), poses[v], s.views[v], side);
      const std::vector<SeenCorner>& corners = s.views[v].of(side);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        if (errors[i].norm() <= most) {
          kept.of(side).push_back(corners[i]);
        } else {
          out.push_back({kept.name, side, corners[i].id, errors[i].norm()});
        }
      }
    }
    const std::size_t all = s.views[v].left.size() + s.views[v].right.size();
    dropped = dropped || !out.empty();
    if (static_cast<double>(out.size()) > kMostOutliers * static_cast<double>(all) ||
        kept.left.size() + kept.right.size() < kLeastCornersOfView) {
      s.dropped_views.push_back(kept.name);
      continue;
    }
    s.dropped_corners.insert(s.dropped_corners.end(), out.begin(), out.end());
    views.push_back(std::move(kept));
    kept_poses.push_back(poses[v]);
  }
  s.views = std::move(views);
  poses = std::move(kept_poses);
  return dropped;
}

// Poses of the views by what is seen of them: the left camera's, else the right one's.
std::vector<RigidTransform> view_poses(const std::vector<View>& views, const OneCamera& left, const OneCamera& right,
                                       const RigidTransform& T_right_left) {
  std::vector<RigidTransform> out;
  for (std::size_t v = 0; v < views.size(); ++v) {
    out.push_back(views[v].left.empty() ? T_right_left.inverse() * right.T_camera_board[v] : left.T_camera_board[v]);
  }
  return out;
}

Result<Solution> solve_with(const Board& board, std::vector<View> views, int width, int height, const LensModel& model,
                            const SolveOptions& options) {
  const auto left = calibrate_one(board, one_side(views, Side::left), model, width, height);
  auto right = calibrate_one(board, one_side(views, Side::right), model, width, height);
  if (!left || !right) {
    return Error{"no calibration fits", model.name,
                 "no focal length explains the corners: is the board the right one?"};
  }
  if (largest_tilt(left->T_camera_board, views) < kLeastTilt_rad) {
    return Error{"the views are all parallel", fmt::format("{} views", views.size()),
                 "tilt the board in different directions: views of one tilt do not fix the focal length"};
  }
  const auto rig_pose = find_rig(board, views, *left, *right);
  if (!rig_pose) {
    return Error{"no pair shows the board to both cameras", fmt::format("{} views", views.size()),
                 "hold the board where both see it"};
  }
  Rig rig;
  rig.model = &model;
  rig.left = left->lens;
  rig.right = right->lens;
  rig.T_right_left = rig_pose->T_right_left;
  rig.width = width;
  rig.height = height;
  Solution s;
  s.views = std::move(views);
  std::vector<RigidTransform> poses = view_poses(s.views, *left, *right, rig.T_right_left);
  s.adjusted = adjust(board, s.views, rig, poses, options_of(model, options, true));
  for (int round = 0; round < 2; ++round) {
    poses = s.adjusted.T_left_board;
    if (!drop_outliers(board, s, poses)) break;
    if (s.views.size() < kLeastViews) break;
    s.adjusted = adjust(board, s.views, s.rig(), poses, options_of(model, options, true));
  }
  if (s.views.size() < kLeastViews) {
    return Error{"too few views agree",
                 fmt::format("{} of {}", s.views.size(), s.views.size() + s.dropped_views.size()),
                 "a calibration needs at least 5: is the board flat, still, and the one that was named?"};
  }
  s.adjusted = adjust(board, s.views, s.rig(), s.adjusted.T_left_board, options_of(model, options, false));
  return s;
}

Result<void> check_views(const std::vector<View>& views) {
  const auto with = [&](Side side) {
    return std::count_if(views.begin(), views.end(), [&](const View& v) { return !v.of(side).empty(); });
  };
  const auto both =
      std::count_if(views.begin(), views.end(), [](const View& v) { return !v.left.empty() && !v.right.empty(); });
  const auto least = static_cast<std::ptrdiff_t>(kLeastViews);
  for (const Side side : {Side::left, Side::right}) {
    if (with(side) == 0) {
      return Error{fmt::format("the {} camera never saw the board", side == Side::left ? "left" : "right"),
                   fmt::format("{} views", views.size()), "hold the board where both cameras see it"};
    }
  }
  if (with(Side::left) < least || with(Side::right) < least || both < least) {
    return Error{"too few views",
                 fmt::format("{} of the left camera, {} of the right one, {} of both", with(Side::left),
                             with(Side::right), both),
                 "at least 5 of both are needed, 20 are good"};
  }
  return {};
}

Result<void> check_order(const Rig& rig) {
  const Eigen::Vector3d left_of_right = rig.T_right_left.inverse().t;  // the right camera, seen from the left one
  if (left_of_right.x() > 0.0 && std::abs(left_of_right.x()) > left_of_right.tail<2>().norm()) return {};
  if (left_of_right.x() < 0.0 && std::abs(left_of_right.x()) > left_of_right.tail<2>().norm()) {
    return Error{"left and right are exchanged",
                 fmt::format("the right camera is {:.1f} mm to the left of the left one", -1e3 * left_of_right.x()),
                 "exchange the cables or folders, or use --swap-eyes; images that are both mirrored look the same"};
  }
  return Error{"the cameras are not side by side",
               fmt::format("from the left to the right camera: {:.3f} {:.3f} {:.3f} m", left_of_right.x(),
                           left_of_right.y(), left_of_right.z()),
               "stereo odometry needs a rig whose cameras are beside each other"};
}

}  // namespace

double rms_px(const Board& board, const Rig& rig, const RigidTransform& T_left_board, const View& view, Side side) {
  double squared = 0.0;
  double count = 0.0;
  for (const Eigen::Vector2d& e : residuals(board, rig, T_left_board, view, side)) {
    if (!e.allFinite()) continue;
    squared += e.squaredNorm();
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(squared / count) : 0.0;
}

double rms_px(const Board& board, const Solution& s) {
  double squared = 0.0;
  double count = 0.0;
  for (std::size_t v = 0; v < s.views.size(); ++v) {
    for (const Side side : {Side::left, Side::right}) {
      const double rms = rms_px(board, s.rig(), s.adjusted.T_left_board[v], s.views[v], side);
      const auto n = static_cast<double>(s.views[v].of(side).size());
      squared += n * rms * rms;
      count += n;
    }
  }
  return count > 0.0 ? std::sqrt(squared / count) : 0.0;
}

Result<Solution> solve(const Board& board, std::vector<View> views, int width, int height,
                       const SolveOptions& options) {
  std::erase_if(views, [](View& view) {
    for (const Side side : {Side::left, Side::right}) {
      if (view.of(side).size() < kLeastCornersOfView) view.of(side).clear();
    }
    return view.left.empty() && view.right.empty();
  });
  if (auto ok = check_views(views); !ok) return ok.error();
  const auto say = [&](const std::string& step) {
    if (options.progress) options.progress(step);
  };
  std::optional<Solution> best;
  std::vector<Solution::Tried> tried;
  std::optional<Error> failure;
  for (const LensModel& model : lens_models()) {
    if (options.model != "auto" && options.model != model.name) continue;
    say(fmt::format("lens model {}", model.name));
    auto solution = solve_with(board, views, width, height, model, options);
    if (!solution) {
      if (!failure) failure = solution.error();
      continue;
    }
    if (options.held_out || options.model == "auto") {
      solution->held_out = hold_out(board, *solution, options_of(model, options, false));
    }
    tried.push_back({model.name, solution->held_out});
    const double error = solution->held_out.reprojection_rms_px;
    if (best && !(error < kClearlyBetter * best->held_out.reprojection_rms_px)) continue;
    best = std::move(*solution);
  }
  if (!best && failure) return *failure;
  if (!best)
    return Error{"unknown lens model", options.model, "choose auto, radtan, plumb_bob, rational or equidistant"};
  best->tried = std::move(tried);
  if (auto ok = check_order(best->rig()); !ok) return ok.error();
  return std::move(*best);
}

}  // namespace cliquevo::calibration
