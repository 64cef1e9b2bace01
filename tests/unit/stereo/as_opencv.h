// SPDX-License-Identifier: BSD-3-Clause
// Our images as OpenCV's and the other way round, without a copy.
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

#include "core/base/image.h"

namespace cliquevo::test {

inline cv::Mat as_mat(Image<std::uint8_t>& i) {
  return {i.height(), i.width(), CV_8UC1, i.view().data, static_cast<std::size_t>(i.view().stride)};
}

inline ImageView<const std::uint8_t> as_view(const cv::Mat& m) {
  return {m.data, m.cols, m.rows, static_cast<std::ptrdiff_t>(m.step)};
}

}  // namespace cliquevo::test
