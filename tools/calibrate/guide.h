// SPDX-License-Identifier: BSD-3-Clause
// Guides whoever holds the board: which views are worth taking, what is still missing, and when it is enough.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "drivers/board_calibration/board.h"
#include "drivers/board_calibration/solve.h"
#include "drivers/board_calibration/views.h"
#include "tools/calibrate/held_view.h"

namespace cliquevo::tools {

// What a pair shows.
struct Look {
  calibration::View view;
  std::array<double, 2> edge_px{};   // edge_width_px() by Side; 0: not seen
  std::optional<double> speed_px_s;  // of the board in the image; none: it was not seen just before
  double skew_s = 0.0;               // between the exposures, as far as stamps show it
};

enum class Refusal { none, no_board, moving, skewed, blurred, alike };

struct GuideOptions {
  std::size_t most_views = 150;
  double exposure_s = 0.01;  // how long a pair is exposed, at most: what moves meanwhile is blurred
};

// Where and how the board is held.
struct Holding {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // of the corners, of the image's size
  double share = 0.0;                                // of the image's width that it takes
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();    // sines of the tilt: its right side away, its lower side away
  double distance_m = 0.0;
};

struct Bar {
  const char* name;
  double share = 0.0;  // of what is wanted, 0 to 1
};

inline constexpr int kCellsAcross = 8;
inline constexpr int kCellsDown = 6;
using Cells = std::array<bool, static_cast<std::size_t>(kCellsAcross* kCellsDown)>;

class Guide {
 public:
  Guide(const calibration::Board& board, int width, int height, const GuideOptions& options);

  // Why a pair is not worth taking.
  Refusal judge(const Look& look);
  // Takes it in any case; every few views the rig is estimated.
  void take(calibration::View view);
  // The board is still held where the last view was taken: whether another pair makes that view more certain.
  bool improves_last(const Look& look, Refusal refusal) const;
  void improve_last(const calibration::View& again);
  void drop_last();

  const std::vector<calibration::View>& views() const { return views_; }
  const Cells& cells(calibration::Side side) const { return cells_[static_cast<std::size_t>(side)]; }
  // image left, image right, scale, tilt, distance, precision
  std::array<Bar, 6> bars() const;
  // What to do now, in words.
  std::string advice(const Look& look, Refusal refusal) const;
  // "lower left, closer, tilted up"; empty: nothing is missing.
  std::string next() const;
  bool enough() const;
  // The latest estimate in words; empty: none yet.
  const std::string& estimate() const { return estimate_; }

 private:
  Holding holding_of(const calibration::View& view) const;
  bool is_alike(const Holding& holding) const;
  bool fills_cells(const calibration::View& view) const;
  void fill(const calibration::View& view);
  void gather();
  void estimate_rig();
  std::string missing_place() const;

  calibration::Board board_;
  int width_, height_;
  GuideOptions options_;
  std::vector<calibration::View> views_;
  HeldView last_;  // of the last view, while the board is held there
  std::vector<Holding> holdings_;
  std::array<Cells, 2> cells_{};
  std::vector<double> edges_;  // of all that was seen, to know how sharp this camera can be
  const calibration::LensModel* model_ = nullptr;
  std::array<calibration::LensVector, 2> lenses_;
  std::size_t estimated_at_ = 0;  // number of views
  double drift_percent_ = 0.0;    // of the way, by the uncertainty of all parameters; 0: not known
  std::string estimate_;
};

}  // namespace cliquevo::tools
