// SPDX-License-Identifier: BSD-3-Clause
// Both cameras' images in one folder: names that contain the side, or one picture with both halves.
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>

#include "drivers/images/image_reader.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/side_words.h"
#include "stereo/camera_order.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

constexpr int kFoldersBelow = 2;

struct Sides {
  ImageList left;
  ImageList right;
  std::size_t pairs = 0;
};

// The images of each side under one reading; names are what both images of a pair share.
Sides split_by(const ImageList& all, int kind) {
  Sides out;
  out.left.folder = out.right.folder = all.folder;
  std::set<std::string> left;
  std::set<std::string> right;
  for (const RecordedImage& image : all.images) {
    if (image.name.find_first_not_of("0123456789") == std::string::npos) continue;  // a number alone counts frames
    for (const Side side : {Side::left, Side::right}) {
      const auto name = without_side(image.name, kind, side);
      if (!name || !(side == Side::left ? left : right).insert(*name).second) continue;
      (side == Side::left ? out.left : out.right).images.push_back({image.path, *name, std::nullopt});
      break;
    }
  }
  for (ImageList* list : {&out.left, &out.right}) {
    std::sort(list->images.begin(), list->images.end(),
              [](const RecordedImage& a, const RecordedImage& b) { return natural_less(a.name, b.name); });
  }
  out.pairs = static_cast<std::size_t>(
      std::count_if(left.begin(), left.end(), [&](const std::string& name) { return right.count(name) > 0; }));
  return out;
}

// Most of the images must be in pairs: "frame1, frame2, frame3" are none.
std::optional<std::pair<Sides, int>> sides_of(const ImageList& all) {
  constexpr double kLeastShare = 0.6;
  std::set<int> kinds;
  for (const RecordedImage* image : {&all.images.front(), &all.images.back()}) {
    for (const SideReading& reading : read_sides(image->name)) kinds.insert(reading.kind);
  }
  for (const int kind : kinds) {
    if (kind > kFirstNumberKind + 8) break;
    Sides sides = split_by(all, kind);
    const double share = 2.0 * static_cast<double>(sides.pairs) / static_cast<double>(all.images.size());
    if (share >= kLeastShare) return std::pair{std::move(sides), kind};
  }
  return std::nullopt;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& part : parts) out += (out.empty() ? "" : "/") + part;
  return out.empty() ? "." : out;
}

Error several(const std::string& path, const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return {"folder holds several recordings", path, "name one of them: " + list.substr(0, 400)};
}

Result<Layout> finish(Layout layout, const std::string& path) {
  if (auto ok = find_stamps(layout, path); !ok) return ok.error();
  layout.calibration = calibration_between(layout.root, path);
  return layout;
}

// The halves of the first image that can be read show the same scene from two places.
bool halves_match(const ImageList& list) {
  constexpr double kLeastAspect = 1.8;
  constexpr double kLeastShare = 0.35;
  constexpr std::size_t kTries = 3;
  ImageReader reader;
  Image<std::uint8_t> image;
  for (std::size_t i = 0; i < std::min(kTries, list.images.size()); ++i) {
    if (!reader.read(list.images[i].path, image)) continue;
    const ImageView<const std::uint8_t> view = image.cview();
    if (view.width % 2 != 0 || view.width < kLeastAspect * view.height) return false;
    const int half = view.width / 2;
    auto check = stereo::CameraOrderCheck::make(half, view.height);
    if (!check) return false;
    const ImageView<const std::uint8_t> left{view.data, half, view.height, view.stride};
    const ImageView<const std::uint8_t> right{view.data + half, half, view.height, view.stride};
    const stereo::OrderEvidence seen = check->measure(left, right);
    return seen.identical || std::max(seen.forward, seen.backward) >= kLeastShare;
  }
  return false;
}

Layout side_by_side_in(const ImageFolder& folder, ImageList list) {
  Layout layout;
  layout.description = "side-by-side images in " + folder.path;
  layout.root = folder.path;
  layout.side_by_side = true;
  layout.left = std::move(list);
  layout.right = layout.left;
  return layout;
}

std::vector<ImageFolder> shallowest(const std::string& path) {
  std::vector<ImageFolder> folders = folders_with_images(path, kFoldersBelow);
  std::size_t least = kFoldersBelow;
  for (const ImageFolder& f : folders) least = std::min(least, f.parts.size());
  folders.erase(
      std::remove_if(folders.begin(), folders.end(), [&](const ImageFolder& f) { return f.parts.size() != least; }),
      folders.end());
  return folders;
}

}  // namespace

Result<std::optional<Layout>> find_names_in_one_folder(const std::string& path) {
  std::vector<Layout> found;
  std::vector<std::string> names;
  std::size_t depth = kFoldersBelow + 1;
  for (const ImageFolder& folder : folders_with_images(path, kFoldersBelow)) {
    if (folder.parts.size() > depth) continue;
    const Result<ImageList> all = list_images(folder.path);
    if (!all) continue;
    auto sides = sides_of(*all);
    if (!sides) continue;
    if (folder.parts.size() < depth) found.clear(), names.clear();
    depth = folder.parts.size();
    Layout layout;
    layout.description =
        fmt::format("images of both cameras in {} ({} in their names)", folder.path, kind_name(sides->second));
    layout.root = folder.path;
    layout.left = std::move(sides->first.left);
    layout.right = std::move(sides->first.right);
    const std::size_t others = all->images.size() - layout.left.images.size() - layout.right.images.size();
    if (others > 0) layout.notes.push_back(fmt::format("{} other images left out", others));
    found.push_back(std::move(layout));
    names.push_back(joined(folder.parts));
  }
  if (found.empty()) return std::optional<Layout>{};
  if (found.size() > 1) return several(path, names);
  auto layout = finish(std::move(found.front()), path);
  if (!layout) return layout.error();
  return std::optional<Layout>(std::move(*layout));
}

Result<std::optional<Layout>> find_side_by_side(const std::string& path) {
  const std::vector<ImageFolder> folders = shallowest(path);
  if (folders.size() != 1) return std::optional<Layout>{};
  Result<ImageList> list = list_images(folders.front().path);
  if (!list || !halves_match(*list)) return std::optional<Layout>{};
  auto layout = finish(side_by_side_in(folders.front(), std::move(*list)), path);
  if (!layout) return layout.error();
  return std::optional<Layout>(std::move(*layout));
}

Result<Layout> read_side_by_side(const std::string& path) {
  const std::vector<ImageFolder> folders = shallowest(path);
  if (folders.empty()) {
    return Error{"folder holds no images", path, "copy the recording again (png, jpg, pgm, ...)"};
  }
  if (folders.size() > 1) {
    std::vector<std::string> names;
    names.reserve(folders.size());
    for (const ImageFolder& folder : folders) names.push_back(joined(folder.parts));
    return several(path, names);
  }
  Result<ImageList> list = list_images(folders.front().path);
  if (!list) return list.error();
  return finish(side_by_side_in(folders.front(), std::move(*list)), path);
}

}  // namespace cliquevo::drivers
