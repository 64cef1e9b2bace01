// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/pairing.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "core/base/saturating.h"

namespace cliquevo::drivers {

namespace {

bool all_stamped(const ImageList& list) {
  return std::all_of(list.images.begin(), list.images.end(),
                     [](const RecordedImage& i) { return i.stamp_ns.has_value(); });
}

// The first image that the other camera has no namesake for; nullptr = the same names.
const RecordedImage* first_without_namesake(const ImageList& a, const ImageList& b) {
  std::size_t j = 0;
  for (const RecordedImage& image : a.images) {
    if (j >= b.images.size() || b.images[j].name != image.name) return &image;
    ++j;
  }
  return j < b.images.size() ? &b.images[j] : nullptr;
}

// "left_000012" -> 12: the last run of digits, to pair names that differ in the camera's name only.
std::string number_in(const std::string& name) {
  const std::size_t end = name.find_last_of("0123456789");
  if (end == std::string::npos) return {};
  const std::size_t before = name.find_last_not_of("0123456789", end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return name.substr(begin, end - begin + 1);
}

bool same_numbers(const ImageList& a, const ImageList& b) {
  if (a.images.size() != b.images.size()) return false;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    const std::string number = number_in(a.images[i].name);
    if (number.empty() || number != number_in(b.images[i].name)) return false;
    if (i > 0 && number == number_in(a.images[i - 1].name)) return false;
  }
  return true;
}

// Images in the order of their times; those that repeat one are left out.
ImageList in_order(const ImageList& list) {
  ImageList out = list;
  std::stable_sort(out.images.begin(), out.images.end(),
                   [](const RecordedImage& a, const RecordedImage& b) { return *a.stamp_ns < *b.stamp_ns; });
  out.images.erase(std::unique(out.images.begin(), out.images.end(),
                               [](const RecordedImage& a, const RecordedImage& b) { return a.stamp_ns == b.stamp_ns; }),
                   out.images.end());
  return out;
}

std::vector<TimestampNs> stamps_of(const ImageList& list) {
  std::vector<TimestampNs> stamps;
  stamps.reserve(list.images.size());
  for (const RecordedImage& image : list.images) stamps.push_back(*image.stamp_ns);
  return stamps;
}

std::size_t nearest(const std::vector<TimestampNs>& stamps, TimestampNs t) {
  const auto after = std::lower_bound(stamps.begin(), stamps.end(), t);
  if (after == stamps.begin()) return 0;
  if (after == stamps.end()) return stamps.size() - 1;
  const auto i = static_cast<std::size_t>(after - stamps.begin());
  return *after - t < t - stamps[i - 1] ? i : i - 1;
}

Result<Pairing> pair_by_time(const Layout& layout, std::optional<double> pair_tolerance_s) {
  const ImageList left_list = in_order(layout.left);
  const ImageList right_list = in_order(layout.right);
  const std::vector<TimestampNs> left = stamps_of(left_list);
  const std::vector<TimestampNs> right = stamps_of(right_list);
  const std::int64_t tolerance = pair_tolerance_ns(pair_tolerance_s, left);
  Pairing pairing;
  for (const auto& [i, j] : nearest_pairs(left, right, tolerance)) {
    pairing.pairs.push_back({left[i], left_list.images[i].path, right_list.images[j].path});
  }
  pairing.unpaired =
      static_cast<std::int64_t>(layout.left.images.size() + layout.right.images.size() - 2 * pairing.pairs.size());
  if (pairing.pairs.empty()) {
    return Error{fmt::format("no image of the left camera is within {:.6g} s of one of the right",
                             static_cast<double>(tolerance) * 1e-9),
                 layout.root, "give a larger --pair-tolerance, or correct the stamps"};
  }
  return pairing;
}

// Each left image with its namesake; one that lacks it keeps its place among the pairs, and is not to be played.
Pairing pair_by_name(const Layout& layout) {
  std::map<std::string, const RecordedImage*> right;
  for (const RecordedImage& image : layout.right.images) right[image.name] = &image;
  Pairing pairing;
  std::size_t paired = 0;
  for (const RecordedImage& image : layout.left.images) {
    const auto found = right.find(image.name);
    paired += found != right.end() ? 1 : 0;
    pairing.pairs.push_back(
        {image.stamp_ns.value_or(0), image.path, found != right.end() ? found->second->path : std::string{}});
  }
  pairing.unpaired = static_cast<std::int64_t>(layout.left.images.size() + layout.right.images.size() - 2 * paired);
  return pairing;
}

std::size_t common_names(const ImageList& a, const ImageList& b) {
  std::set<std::string> names;
  for (const RecordedImage& image : a.images) names.insert(image.name);
  return static_cast<std::size_t>(std::count_if(
      b.images.begin(), b.images.end(), [&](const RecordedImage& image) { return names.count(image.name) > 0; }));
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> nearest_pairs(const std::vector<TimestampNs>& left,
                                                               const std::vector<TimestampNs>& right,
                                                               std::int64_t tolerance_ns) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  if (right.empty()) return pairs;
  for (std::size_t i = 0; i < left.size(); ++i) {
    const std::size_t j = nearest(right, left[i]);
    if (nearest(left, right[j]) == i && saturated_distance(right[j], left[i]) <= tolerance_ns) pairs.emplace_back(i, j);
  }
  return pairs;
}

std::int64_t pair_tolerance_ns(std::optional<double> given_s, const std::vector<TimestampNs>& stamps) {
  return given_s ? static_cast<std::int64_t>(std::llround(*given_s * 1e9)) : median_period_ns(stamps) / 4;
}

std::int64_t median_period_ns(const std::vector<TimestampNs>& stamps) {
  if (stamps.size() < 2) return 0;
  std::vector<std::int64_t> periods;
  periods.reserve(stamps.size() - 1);
  for (std::size_t i = 1; i < stamps.size(); ++i) periods.push_back(stamps[i] - stamps[i - 1]);
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return *middle;
}

Result<Pairing> pair_images(const Layout& layout, std::optional<double> rate_hz,
                            std::optional<double> pair_tolerance_s) {
  const RecordedImage* odd = first_without_namesake(layout.left, layout.right);
  const bool by_time = odd != nullptr && all_stamped(layout.left) && all_stamped(layout.right);
  const bool by_name = 2 * common_names(layout.left, layout.right) > layout.left.images.size();
  if (odd != nullptr && !by_time && !by_name && !same_numbers(layout.left, layout.right)) {
    return Error{"image has no partner in the other camera", odd->path,
                 "copy the recording again; or give both cameras times of their own to pair them by time"};
  }
  if (!all_stamped(layout.left) && !rate_hz) {
    return Error{"recording has no times", layout.root,
                 "give the frame rate with --rate HZ, or add times.txt with one time in seconds a line"};
  }
  Pairing pairing;
  if (by_time) {
    auto paired = pair_by_time(layout, pair_tolerance_s);
    if (!paired) return paired.error();
    pairing = std::move(*paired);
  } else if (by_name) {
    pairing = pair_by_name(layout);
  } else {
    for (std::size_t i = 0; i < layout.left.images.size(); ++i) {
      const RecordedImage& image = layout.left.images[i];
      pairing.pairs.push_back({image.stamp_ns.value_or(0), image.path, layout.right.images[i].path});
    }
  }
  if (!rate_hz) return pairing;
  for (std::size_t i = 0; i < pairing.pairs.size(); ++i) pairing.pairs[i].stamp_ns = stamp_at(i, *rate_hz);
  return pairing;
}

TimestampNs stamp_at(std::size_t i, double rate_hz) {
  constexpr double kMost = 4e18;
  return static_cast<TimestampNs>(std::llround(std::min(kMost, static_cast<double>(i) * 1e9 / rate_hz)));
}

}  // namespace cliquevo::drivers
