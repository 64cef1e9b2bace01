// SPDX-License-Identifier: BSD-3-Clause
// What a recording's images are like, found out once over some of them, so that all are treated alike.
#pragma once

#include <string>
#include <vector>

#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"

namespace cliquevo::drivers {

struct DepthSurvey {
  bool deep = false;  // there are images of more than 8 bits
  int shift = 0;      // bits by which those are shifted down: both cameras', all along
};
// Over the whole of the first, the last and some pairs between; images that cannot be read are next()'s to report.
DepthSurvey survey_depth(const std::vector<ImagePair>& pairs);
// "samples of 12 bits, scaled by 1/16"; empty where nothing is scaled.
std::string describe_depth(const DepthSurvey& survey);

// Whether the store's images are Bayer mosaics, over the first, the middle and the last pair of both cameras.
struct MosaicSurvey {
  bool mosaic = false;
  std::string text;  // "Bayer mosaic (RGGB or BGGR), made grey"; empty for ordinary images
};
MosaicSurvey survey_mosaic(PairStore& store, Bayer wanted);

}  // namespace cliquevo::drivers
