// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/image_survey.h"

#include <algorithm>

#include <fmt/format.h>

#include "drivers/images/image_reader.h"
#include "drivers/images/sample_depth.h"

namespace cliquevo::drivers {

namespace {

// Up to `wanted` of 0 to count - 1, evenly, with the first and the last.
std::vector<std::size_t> spread(std::size_t count, std::size_t wanted) {
  std::vector<std::size_t> out;
  const std::size_t n = std::min(count, wanted);
  for (std::size_t i = 0; i < n; ++i) out.push_back(n == 1 ? 0 : i * (count - 1) / (n - 1));
  return out;
}

const char* name_of(Bayer pattern) {
  switch (pattern) {
    case Bayer::rggb:
      return "RGGB";
    case Bayer::bggr:
      return "BGGR";
    case Bayer::grbg:
      return "GRBG";
    case Bayer::gbrg:
      return "GBRG";
    case Bayer::automatic:
    case Bayer::none:
      break;
  }
  return "none";
}

}  // namespace

DepthSurvey survey_depth(const std::vector<ImagePair>& pairs) {
  constexpr std::size_t kPairs = 8;
  SampleDepth depth;
  ImageReader reader;
  bool first = true;
  for (const std::size_t i : spread(pairs.size(), kPairs)) {
    for (const std::string* file : {&pairs[i].left, &pairs[i].right}) {
      if (file->empty()) continue;
      const auto picture = reader.read_as_stored(*file);
      if (picture.ok()) depth.add(**picture);
    }
    if (first && !depth.deep()) break;  // ordinary images are not looked at twice
    first = false;
  }
  return {depth.deep(), depth.deep() ? depth.shift() : 0};
}

std::string describe_depth(const DepthSurvey& survey) {
  if (!survey.deep) return {};
  if (survey.shift == 0) return "samples of 8 bits in 16, taken as they are";
  return fmt::format("samples of {} bits, scaled by 1/{}", survey.shift + 8, 1 << survey.shift);
}

MosaicSurvey survey_mosaic(PairStore& store, Bayer wanted) {
  constexpr std::size_t kPairs = 3;
  if (wanted == Bayer::none) return {};
  if (wanted != Bayer::automatic) return {true, fmt::format("Bayer mosaic ({}), made grey", name_of(wanted))};
  MosaicEvidence left;
  MosaicEvidence right;
  StereoPair pair;
  for (const std::size_t i : spread(static_cast<std::size_t>(store.size()), kPairs)) {
    if (!store.load(static_cast<std::int64_t>(i), pair)) continue;
    left.add(pair.left.cview());
    right.add(pair.right.cview());
  }
  if (!left.is_mosaic() || !right.is_mosaic()) return {};
  return {true, fmt::format("Bayer mosaic ({}), made grey; --bayer none if it is none",
                            left.green_first() ? "GRBG or GBRG" : "RGGB or BGGR")};
}

}  // namespace cliquevo::drivers
