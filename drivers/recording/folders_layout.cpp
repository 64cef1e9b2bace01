// SPDX-License-Identifier: BSD-3-Clause
// Two folders of images whose paths differ in the word for left and right.
#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "drivers/recording/layout.h"
#include "drivers/recording/letters.h"
#include "drivers/recording/side_words.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

constexpr int kDepth = 5;

bool has_word(const ImageFolder& folder, std::initializer_list<const char*> words) {
  return std::any_of(folder.parts.begin(), folder.parts.end(), [&](const std::string& part) {
    const std::string name = lower(part);
    return std::any_of(words.begin(), words.end(), [&](const char* w) { return name.find(w) != std::string::npos; });
  });
}

// Pictures of something else than what the camera sees.
bool is_by_product(const ImageFolder& f) {
  return has_word(f, {"disp", "depth", "mask", "seg", "semantic", "flow", "label", "normal", "conf", "occ", "gt",
                      "ground", "debug", "thumb", "calib", "event"});
}

bool is_number(const std::string& text) { return text.find_first_not_of("0123456789") == std::string::npos; }

struct FolderPair {
  const ImageFolder* left = nullptr;
  const ImageFolder* right = nullptr;
  int kind = 0;
  std::string parent;        // what both have in common before their paths part
  bool bare_number = false;  // the side is given by a number alone

  // The lower, the likelier it is meant.
  auto rank() const {
    const bool rectified = has_word(*left, {"rect", "undist"}) && !has_word(*left, {"unrect", "nonrect"});
    return std::tuple(is_by_product(*left), left->parts.size(), bare_number, kind, !rectified);
  }
  // Paths that part at the beginning hide no recording of their own in their parent.
  std::string name() const {
    std::string out;
    for (const std::string& part : left->parts) out += (out.empty() ? "" : "/") + part;
    return out;
  }
};

// Part by part the same, or left and right of the same kind.
std::optional<FolderPair> pair_of(const ImageFolder& left, const ImageFolder& right) {
  if (left.parts.size() != right.parts.size() || left.path == right.path) return std::nullopt;
  FolderPair out{&left, &right, -1, {}, false};
  for (std::size_t i = 0; i < left.parts.size(); ++i) {
    if (left.parts[i] == right.parts[i]) {
      if (out.kind < 0) out.parent += (out.parent.empty() ? "" : "/") + left.parts[i];
      continue;
    }
    const auto kind = pair_kind(left.parts[i], right.parts[i]);
    if (!kind) return std::nullopt;
    if (out.kind < 0) out.kind = *kind;
    out.bare_number = out.bare_number || is_number(left.parts[i]);
  }
  return out.kind < 0 ? std::nullopt : std::optional(out);
}

// The only two folders of images, side by side, whose names differ in the cameras' numbers.
std::optional<FolderPair> only_two(const std::vector<ImageFolder>& folders) {
  if (folders.size() != 2 || folders[0].parts.size() != folders[1].parts.size()) return std::nullopt;
  for (const bool first : {true, false}) {
    const ImageFolder& left = folders[first ? 0 : 1];
    const ImageFolder& right = folders[first ? 1 : 0];
    FolderPair out{&left, &right, -1, {}, false};
    bool other = false;
    for (std::size_t i = 0; i < left.parts.size(); ++i) {
      if (left.parts[i] == right.parts[i]) {
        if (out.kind < 0) out.parent += (out.parent.empty() ? "" : "/") + left.parts[i];
        continue;
      }
      other = other || out.kind >= 0 || is_number(left.parts[i]) || !differ_in_a_number(left.parts[i], right.parts[i]);
      out.kind = kFirstNumberKind;
    }
    if (!other && out.kind >= 0) return out;
  }
  return std::nullopt;
}

// Names that contain the side themselves ("left_0001" and "right_0001") lose that word, so that they match by name.
void strip_sides(Layout& layout) {
  if (same_names(layout.left, layout.right) || layout.left.images.empty()) return;
  for (const SideReading& reading : read_sides(layout.left.images.front().name)) {
    if (reading.side != Side::left || reading.kind >= kFirstNumberKind + 4) continue;
    const auto stripped = [&](const ImageList& list, Side side) -> std::optional<ImageList> {
      ImageList out = list;
      std::set<std::string> seen;
      for (RecordedImage& image : out.images) {
        const auto name = without_side(image.name, reading.kind, side);
        if (!name || name->empty() || !seen.insert(*name).second) return std::nullopt;
        image.name = *name;
      }
      std::sort(out.images.begin(), out.images.end(),
                [](const RecordedImage& a, const RecordedImage& b) { return natural_less(a.name, b.name); });
      return out;
    };
    auto left = stripped(layout.left, Side::left);
    auto right = stripped(layout.right, Side::right);
    if (!left || !right || !same_names(*left, *right)) continue;
    layout.left = std::move(*left);
    layout.right = std::move(*right);
    return;
  }
}

// Of the pairs that rank equally: the one to take, and whether others are recordings of their own.
Result<FolderPair> choose(const std::vector<FolderPair>& pairs, const std::string& path,
                          std::vector<std::string>& notes) {
  const FolderPair* best = &pairs.front();
  for (const FolderPair& pair : pairs) {
    if (pair.rank() < best->rank()) best = &pair;
  }
  std::set<std::string> parents;
  std::vector<std::string> others;
  for (const FolderPair& pair : pairs) {
    if (pair.rank() != best->rank()) continue;
    parents.insert(pair.parent);
    if (&pair != best) others.push_back(pair.name());
  }
  if (parents.size() > 1) {
    std::string names;
    for (const std::string& parent : parents) names += (names.empty() ? "" : ", ") + parent;
    return Error{"folder holds several recordings", path, "name one of them: " + names.substr(0, 400)};
  }
  if (!others.empty()) notes.push_back(fmt::format("{} taken, {} is there as well", best->name(), others.front()));
  return *best;
}

}  // namespace

Result<std::optional<Layout>> find_two_folders(const std::string& path) {
  const std::vector<ImageFolder> folders = folders_with_images(path, kDepth);
  std::vector<FolderPair> pairs;
  for (const ImageFolder& left : folders) {
    for (const ImageFolder& right : folders) {
      if (auto pair = pair_of(left, right)) pairs.push_back(std::move(*pair));
    }
  }
  // Folders that are but numbered are two cameras only where there are no more than two.
  const auto numbered = std::count_if(folders.begin(), folders.end(), [](const ImageFolder& f) {
    return !f.parts.empty() && is_number(f.parts.front());
  });
  if (numbered > 2) {
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [](const FolderPair& p) { return p.bare_number; }),
                pairs.end());
  }
  Layout layout;
  if (pairs.empty()) {
    auto pair = only_two(folders);
    if (!pair) return std::optional<Layout>{};
    layout.notes.push_back(fmt::format("{} taken for the left camera's, {} for the right one's", pair->name(),
                                       FolderPair{pair->right, pair->left, 0, {}, false}.name()));
    pairs.push_back(std::move(*pair));
  }
  const auto best = choose(pairs, path, layout.notes);
  if (!best) return best.error();
  const fs::path parent = fs::path(path) / best->parent;
  layout.description = "two folders of images in " + parent.lexically_normal().string();
  if (best->parent.empty()) layout.description = "two folders of images in " + path;
  layout.root = best->parent.empty() ? path : parent.string();
  if (best->left->parts.size() > 1 || best->kind != kWordKind) {
    layout.description += fmt::format(" ({} left)", best->name());
  }
  if (auto ok = list_both_sides(layout, best->left->path, best->right->path); !ok) return ok.error();
  strip_sides(layout);
  if (auto ok = find_stamps(layout, path); !ok) return ok.error();
  layout.calibration = calibration_between(layout.root, path);
  return std::optional<Layout>(std::move(layout));
}

Result<std::optional<Layout>> find_single_side(const std::string& path) {
  for (const ImageFolder& folder : folders_with_images(path, 2)) {
    if (folder.parts.empty()) continue;
    for (std::size_t i = 0; i < folder.parts.size(); ++i) {
      const std::vector<SideReading> readings = read_sides(folder.parts[i]);
      if (readings.empty() || readings.front().kind != kWordKind) continue;
      const bool left = readings.front().side == Side::left;
      // The other word in the same case.
      std::string partner = folder.parts[i];
      const std::string word = left ? "left" : "right";
      std::string other = left ? "right" : "left";
      const std::size_t at = lower(partner).find(word);
      const bool capital = partner[at] >= 'A' && partner[at] <= 'Z';
      const bool capitals = capital && partner[at + 1] >= 'A' && partner[at + 1] <= 'Z';
      for (std::size_t k = 0; k < other.size(); ++k) {
        if (capitals || (capital && k == 0)) other[k] = static_cast<char>(other[k] - 'a' + 'A');
      }
      partner.replace(at, word.size(), other);
      fs::path missing(path);
      for (std::size_t k = 0; k < folder.parts.size(); ++k) missing /= k == i ? partner : folder.parts[k];
      std::error_code ec;
      if (fs::is_directory(missing, ec)) {
        return Error{"folder holds no images", missing.string(), "copy the recording again (png, jpg, pgm, ...)"};
      }
      return Error{left ? "right images are missing" : "left images are missing", missing.string(),
                   "copy both folders of the recording"};
    }
  }
  return std::optional<Layout>{};
}

}  // namespace cliquevo::drivers
