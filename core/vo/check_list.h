// SPDX-License-Identifier: BSD-3-Clause
// What is checked of a frame's motion, and which verdict follows: a row a check. Pages, the view and the numbers of
// VO_STATUS are made from it (tools/generate).
#pragma once

#include <cstddef>
#include <cstdint>

namespace cliquevo::vo {

// The verdict on a frame; the numbers go out over LCM.
enum class Status : std::int8_t {
  no_data = 0,             // first frame: nothing to compare with
  valid = 1,               //
  too_few_features = 2,    // features, matches or clique too small
  degenerate = 3,          // spread of the inliers too one-sided to fix the motion
  reprojection_error = 4,  // the inliers do not agree on one motion
  ambiguous = 5,           // a second motion is well supported, or much of the picture contradicts the one found
  weak = 6,                // a motion was found, but by its own covariance it is hardly known
};

// The place is the bit and the index in VO_STATUS (CHECK_... in status_t.lcm): append before `count`, never insert.
enum class Check : std::uint8_t {
  inliers,
  spread,
  positions,
  disparities,
  contradiction,
  running_ground,
  hanging_camera,
  found_again,
  rival,
  uncertainty,
  count
};
inline constexpr std::size_t kChecks = static_cast<std::size_t>(Check::count);  // how many there are

// A check for people.
struct CheckRow {
  Check check;           // which one
  const char* symbol;    // as in the enumeration: its page is docs/checks/SYMBOL.md, with hyphens
  const char* name;      // in messages, statistics and pages
  Status status;         // where it fails
  const char* unit;      // of its value
  const char* meaning;   // of its failure
  const char* question;  // that it answers
  const char* value;     // what is looked at, in full
  const char* bound;     // what it must not exceed, in full
};

// In the order of verdicts: the first that fails decides.
inline constexpr CheckRow kCheckRows[kChecks] = {
    {Check::inliers, "inliers", "inliers", Status::too_few_features, "needed / found",
     "Too few features moved as one: a blank, blurred or dark picture, or a motion that was too fast.",
     "did enough features move as one?", "`min_inliers` over those found", "1"},
    {Check::spread, "spread", "spread", Status::degenerate, "needed / found",
     "The features lie nearly on a line: they do not fix the motion.", "do they cover an area?",
     "`min_eigenvalue_ratio` over that of the inliers' places", "1"},
    {Check::positions, "positions", "positions", Status::reprojection_error, "× noise",
     "The features scatter about the motion more than this camera's noise explains.",
     "are they where the motion puts them?", "reprojection error over the expected one", "`max_error_ratio` 5"},
    {Check::disparities, "disparities", "disparities", Status::reprojection_error, "× noise",
     "The disparities of the features do not fit the motion.", "do their disparities fit it?",
     "the same of the disparities, which count loosely in the solution", "5, down to half of it with little coverage"},
    {Check::hanging_camera, "hanging_camera", "hanging camera", Status::ambiguous, "one / other",
     "One camera's picture moves, the other one stands: it repeats an image.", "does one camera repeat its image?",
     "motion of one image over that of the other, where one moves by more than six expected errors", "4"},
    {Check::contradiction, "contradiction", "contradiction", Status::ambiguous, "of the picture",
     "Much of the picture moved otherwise: something large moves by itself.", "does the whole picture move so?",
     "share of some 120 cells whose best texture is not where the motion puts it, though nothing hides it, both "
     "cameras "
     "see it alike, and it is seen only once along its row and its way (railings, bricks)",
     "`max_contradiction` 0.14"},
    {Check::running_ground, "running_ground", "running ground", Status::ambiguous, "× noise",
     "Surfaces change from frame to frame, as water does.", "do surfaces last from frame to frame?",
     "(change over time, less what a change of blur explains, less difference of left and right, over the smaller: 1 - "
     "correlation, medians) times the error over the expected one, times up to three where the disparities needed are "
     "news, times the error of the disparities over 1.4 expected ones where it is more",
     "`max_running_ground` 4"},
    {Check::found_again, "found_again", "found again", Status::ambiguous, "needed / found",
     "Too few of the features of the frame before were found again.", "was enough of the last view found?",
     "4 % of the references' features over those found; 12.5 % under caution", "1"},
    {Check::rival, "rival", "rival motion", Status::ambiguous, "of a rival",
     "A second motion is as well supported: which of them is the world's?", "is there a second motion as good?",
     "support of another clique's motion over `rival_share` of the first's", "1"},
    {Check::uncertainty, "uncertainty", "uncertainty", Status::weak, "σ / known",
     "By its own covariance the motion is hardly known.", "is the motion known well enough?",
     "standard deviation of the translation over a tenth of it (`max_uncertainty`), or over 0.3 % of the distance of "
     "what is seen, if that is more",
     "1"},
};

}  // namespace cliquevo::vo
