// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/examine.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "drivers/calibration/baseline.h"
#include "drivers/calibration/checks.h"
#include "stereo/pair_evidence.h"
#include "stereo/rectification.h"

namespace cliquevo::drivers {

namespace {

using stereo::RowEvidence;

constexpr int kLeastFound = 30;          // corners, for a judgement
constexpr double kAgreeing = 1.0;        // rows that a corner of a good calibration is off at most, mostly
constexpr double kLeastAgreeing = 0.25;  // share of the corners, of images that are rectified
constexpr double kClearly = 2.0;         // times more corners agree
constexpr double kBetterLens = 1.15;     // likewise, of two models that both fit somehow

RowEvidence rows_as_grabbed(const std::vector<ImagePairView>& pairs) {
  RowEvidence out;
  for (const ImagePairView& pair : pairs) out.add(stereo::measure_rows(pair.left, pair.right));
  return out;
}

RowEvidence rows_by(const StereoCalibration& calibration, const std::vector<ImagePairView>& pairs) {
  if (calibration.rectified) return rows_as_grabbed(pairs);
  RowEvidence out;
  for (const ImagePairView& pair : pairs) {
    const auto seen = stereo::measure_rows(calibration, pair.left, pair.right);
    if (seen) out.add(*seen);
  }
  return out;
}

// Of two lenses the one whose rows agree clearly better.
Result<StereoCalibration> by_lens(const CalibrationRequest& request, const std::vector<ImagePairView>& pairs,
                                  const Error& question) {
  std::optional<StereoCalibration> best;
  double best_share = 0.0;
  double other_share = 0.0;
  const char* name = nullptr;
  for (const char* lens : {"plumb_bob", "equidistant"}) {
    CalibrationRequest as = request;
    as.options.lens = lens;
    auto read = read_calibration(as);
    if (!read) continue;
    const RowEvidence rows = rows_by(*read, pairs);
    const double share = rows.found() >= kLeastFound ? rows.share_within(0.5 * kAgreeing) : 0.0;
    if (share > best_share) {
      other_share = best_share;
      best_share = share;
      best = std::move(*read);
      name = lens;
    } else {
      other_share = std::max(other_share, share);
    }
  }
  if (!best || best_share < kLeastAgreeing || best_share < kBetterLens * other_share) return question;
  best->notes.push_back(
      fmt::format("four distortion terms of an unnamed lens taken for {}: {:.0f} % of the corners are "
                  "in the right rows, by the other model {:.0f} %; --lens {} if not",
                  name, 100.0 * best_share, 100.0 * other_share, name[0] == 'p' ? "equidistant" : "plumb_bob"));
  return *best;
}

std::optional<std::string> rectified_already(const StereoCalibration& c, const RowEvidence& calibrated,
                                             const std::vector<ImagePairView>& pairs) {
  if (c.rectified || calibrated.share_within(kAgreeing) > kLeastAgreeing) return std::nullopt;
  const RowEvidence grabbed = rows_as_grabbed(pairs);
  const double share = grabbed.share_within(kAgreeing);
  if (grabbed.found() < kLeastFound || share < kLeastAgreeing) return std::nullopt;
  if (share < kClearly * calibrated.share_within(kAgreeing) || grabbed.median_off_px() > 0.75 * kAgreeing) {
    return std::nullopt;
  }
  return fmt::format(
      "{:.0f} % of the corners are in the same row of both images as they are, {:.0f} % after "
      "rectification",
      100.0 * share, 100.0 * calibrated.share_within(kAgreeing));
}

std::optional<std::string> baseline_doubt(const StereoCalibration& c, const RowEvidence& rows) {
  if (rows.found() < kLeastFound) return std::nullopt;
  const auto chosen = stereo::choose_rectification(c);
  if (!chosen) return std::nullopt;
  const StereoModel& m = chosen->model;
  const double disparity_px = rows.disparity_px(0.95) + m.doffs_px;
  if (!(disparity_px > 1.0)) return std::nullopt;
  return doubt_baseline(m.baseline_m, m.fx_px * m.baseline_m / disparity_px);
}

}  // namespace

Result<StereoCalibration> read_calibration_for(const CalibrationRequest& request,
                                               const std::vector<ImagePairView>& pairs) {
  Result<StereoCalibration> read = read_calibration(request);
  if (!read && asks_for_lens(read.error()) && !pairs.empty()) read = by_lens(request, pairs, read.error());
  if (!read || pairs.empty()) return read;
  const RowEvidence rows = rows_by(*read, pairs);
  if (const auto seen = rectified_already(*read, rows, pairs)) {
    return Error{"images are rectified already, the calibration is of raw ones", read->source + " (" + *seen + ")",
                 read->prescribed ? "say --rectified (in a configuration: rectified), or name the calibration of the "
                                    "rectified images"
                                  : "name the calibration of the rectified images"};
  }
  if (request.options.baseline_unit_m <= 0.0) {
    if (auto doubt = baseline_doubt(*read, rows)) read->notes.push_back(std::move(*doubt));
  }
  return read;
}

std::string contradiction(const StereoCalibration& calibration, const std::vector<ImagePairView>& pairs) {
  const RowEvidence rows = rows_by(calibration, pairs);
  if (const auto seen = rectified_already(calibration, rows, pairs)) {
    return fmt::format(
        "images are rectified already, the calibration is of raw ones: {} ({}): set rectified, or name "
        "the calibration of the rectified images",
        calibration.source, *seen);
  }
  return baseline_doubt(calibration, rows).value_or("");
}

}  // namespace cliquevo::drivers
