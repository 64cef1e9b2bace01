// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/keys.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <set>

#include <fmt/format.h>

#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

bool is_of_a_camera(Quantity q) {
  switch (q) {
    case Quantity::camera_matrix:
    case Quantity::distortion:
    case Quantity::fx:
    case Quantity::fy:
    case Quantity::cx:
    case Quantity::cy:
    case Quantity::focal:
    case Quantity::focals:
    case Quantity::centre:
    case Quantity::xi:
    case Quantity::k:
    case Quantity::p:
    case Quantity::s:
      return true;
    default:
      return false;
  }
}

// "120 mm", "0.12m": a number and its unit of length.
std::optional<std::pair<double, double>> length_of(std::string_view text) {
  const std::size_t end = text.find_last_of("0123456789.");
  if (end == std::string_view::npos || end + 1 >= text.size()) return std::nullopt;
  const std::optional<double> number = parse_number(trim(text.substr(0, end + 1)));
  const double unit_m = unit_named(std::string(trim(text.substr(end + 1))));
  if (!number || unit_m <= 0.0) return std::nullopt;
  return std::pair{*number, unit_m};
}

}  // namespace

void Keys::add(const Document& document) {
  std::vector<std::string> path;
  walk(document.root(), document.path(), "", path);
  settle_numbers();
}

Result<const KeyEntry*> Keys::find(Quantity quantity, KeySide side, int index) const {
  const KeyEntry* found = nullptr;
  for (const KeyEntry& entry : entries_) {
    if (entry.meaning.quantity != quantity || entry.meaning.side != side || entry.meaning.index != index) continue;
    if (entry.error) return *entry.error;
    if (found != nullptr && (found->numbers != entry.numbers || found->word != entry.word)) {
      return Error{"calibration says the same twice, and differently", entry.where,
                   "leave one of " + printable(found->key) + " and " + printable(entry.key)};
    }
    if (found == nullptr) found = &entry;
  }
  return found;
}

std::vector<const KeyEntry*> Keys::lenses(KeySide side) const {
  std::vector<const KeyEntry*> out;
  for (const KeyEntry& entry : entries_) {
    const KeyMeaning& m = entry.meaning;
    if (m.quantity == Quantity::lens && (m.side == side || m.side == KeySide::none)) out.push_back(&entry);
  }
  return out;
}

bool Keys::has(Quantity quantity, KeySide side) const {
  return std::any_of(entries_.begin(), entries_.end(), [&](const KeyEntry& entry) {
    return entry.meaning.quantity == quantity && entry.meaning.side == side;
  });
}

bool Keys::has(Quantity quantity) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const KeyEntry& entry) { return entry.meaning.quantity == quantity; });
}

namespace {

// {x: 1, y: 2, z: 3}, with w or without: a list of numbers in this order; nothing = it is another map.
std::optional<DocumentNode> as_list(const DocumentNode& node) {
  if (node.entries.size() != 3 && node.entries.size() != 4) return std::nullopt;
  DocumentNode out;
  out.kind = DocumentNode::Kind::list;
  out.line = node.line;
  for (const char* name : {"x", "y", "z", "w"}) {
    if (const DocumentNode* value = node.find(name)) out.items.push_back(*value);
  }
  return out.items.size() == node.entries.size() ? std::optional(std::move(out)) : std::nullopt;
}

// {q_x: 0, q_y: 0, q_z: 0, q_w: 1, t_x: 1, t_y: 2, t_z: 3}: rotation and translation as lists; nothing = another map.
std::optional<std::pair<DocumentNode, DocumentNode>> as_pose(const DocumentNode& node) {
  if (node.entries.size() != 7) return std::nullopt;
  const auto list = [&node](std::initializer_list<std::array<const char*, 4>> spellings) {
    DocumentNode out;
    out.kind = DocumentNode::Kind::list;
    out.line = node.line;
    for (const auto& names : spellings) {
      out.items.clear();
      for (const char* name : names) {
        if (const DocumentNode* value = name != nullptr ? node.find(name) : nullptr) out.items.push_back(*value);
      }
      if (out.items.size() >= 3) break;
    }
    return out;
  };
  DocumentNode q = list({{"q_x", "q_y", "q_z", "q_w"}, {"qx", "qy", "qz", "qw"}});
  DocumentNode t = list({{"t_x", "t_y", "t_z", nullptr}, {"tx", "ty", "tz", nullptr}, {"x", "y", "z", nullptr}});
  if (q.items.size() != 4 || t.items.size() != 3) return std::nullopt;
  return std::pair{std::move(q), std::move(t)};
}

// What a camera in a list says it is: "left", "cam1"; empty = nothing.
std::string name_of(const DocumentNode& item) {
  for (const char* key :
       {"side", "name", "camera_name", "position", "label", "role", "location", "camera", "id", "camera_id", "index"}) {
    const DocumentNode* value = item.find(key);
    if (value == nullptr || value->kind != DocumentNode::Kind::scalar || value->scalar.size() > 64) continue;
    std::string word = value->scalar;
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    const bool left = word.find("left") != std::string::npos || word == "l";
    const bool right = word.find("right") != std::string::npos || word == "r";
    if (left != right) return left ? "left" : "right";
    constexpr const char* kDigits = "0123456789";
    if (!word.empty() && word.find_first_of(kDigits) == word.size() - 1) return std::string("cam") + word.back();
  }
  return {};
}

// The names of a list's items, or else their numbers.
std::vector<std::string> names_of(const std::vector<DocumentNode>& items) {
  std::vector<std::string> names;
  std::vector<std::string> numbers;
  std::set<std::string> different;
  for (std::size_t i = 0; i < items.size() && i < 10; ++i) {
    names.push_back(name_of(items[i]));
    numbers.push_back(std::to_string(i));
    if (!names.back().empty()) different.insert(names.back());
  }
  if (items.size() == 1 && different.empty()) return {""};  // one pose of a list of poses is no camera 0's
  return different.size() == names.size() ? names : numbers;
}

}  // namespace

void Keys::walk(const DocumentNode& node, const std::string& file, const std::string& key,
                std::vector<std::string>& path) {
  if (path.size() > 8 || entries_.size() > 2000) return;
  const bool matrix = node.find("data") != nullptr;
  if (const auto list = as_list(node); list && !path.empty()) return leaf(*list, file, key, path);
  if (const auto pose = as_pose(node)) {
    step(pose->first, file, key, "rotation", path);
    return step(pose->second, file, key, "translation", path);
  }
  if (node.kind == DocumentNode::Kind::map && !matrix) {
    for (const auto& [name, inner] : node.entries) step(inner, file, key, name, path);
    return;
  }
  const bool maps = node.kind == DocumentNode::Kind::list && !node.items.empty() &&
                    node.items.front().kind == DocumentNode::Kind::map;
  if (maps) {
    const std::vector<std::string> names = names_of(node.items);
    for (std::size_t i = 0; i < names.size(); ++i) step(node.items[i], file, key, names[i], path);
    return;
  }
  if (!path.empty()) leaf(node, file, key, path);
}

void Keys::step(const DocumentNode& inner, const std::string& file, const std::string& key, const std::string& name,
                std::vector<std::string>& path) {
  const std::size_t depth = path.size();
  for (std::size_t at = 0; at <= name.size();) {  // "LEFT.K" is "K" in "LEFT"
    const std::size_t dot = std::min(name.find('.', at), name.size());
    path.push_back(name.substr(at, dot - at));
    at = dot + 1;
  }
  walk(inner, file, key.empty() ? name : name.empty() ? key : key + "." + name, path);
  path.resize(depth);
}

void Keys::leaf(const DocumentNode& node, const std::string& file, const std::string& key,
                const std::vector<std::string>& path) {
  KeyEntry entry;
  entry.key = key;
  const std::string shown = printable(key.substr(0, 64));
  entry.where = node.line > 0 ? fmt::format("{}:{} ({})", file, node.line, shown) : fmt::format("{} ({})", file, shown);
  const auto length = node.kind == DocumentNode::Kind::scalar ? length_of(node.scalar) : std::nullopt;
  if (length && meaning_of(path, 1).quantity == Quantity::baseline) {
    entry.meaning = meaning_of(path, 1);
    entry.meaning.quantity = Quantity::baseline_in_unit;
    entry.numbers = {length->first * length->second};
    entries_.push_back(std::move(entry));
    return;
  }
  const Result<std::vector<double>> numbers = numbers_of(node, entry.where);
  if (numbers) {
    entry.numbers = *numbers;
    entry.meaning = meaning_of(path, entry.numbers.size());
    if (entry.meaning.quantity == Quantity::baseline_in_unit) entry.numbers[0] *= entry.meaning.unit_m;
    if (entry.numbers.empty() && node.kind != DocumentNode::Kind::scalar) {
      entry.meaning = meaning_of(path, 5);  // no distortion terms are none, not a word
      if (entry.meaning.quantity != Quantity::distortion) return;
    }
  } else {
    if (node.kind == DocumentNode::Kind::scalar) {
      entry.word = node.scalar;
      entry.meaning = meaning_of(path, 0);
    }
    if (entry.meaning.quantity == Quantity::none) {
      // A matrix or number that is broken must not be passed over.
      for (const std::size_t count : {std::size_t{9}, std::size_t{12}, std::size_t{3}, std::size_t{1}}) {
        if (count == 1 && node.kind != DocumentNode::Kind::scalar) continue;
        entry.meaning = meaning_of(path, count);
        if (entry.meaning.quantity != Quantity::none) break;
      }
      entry.error = numbers.error();
    }
  }
  if (entry.meaning.quantity != Quantity::none) entries_.push_back(std::move(entry));
}

namespace {

bool is_of_numbered(const KeyMeaning& m) {
  return m.quantity == Quantity::camera_matrix || m.quantity == Quantity::fx || m.quantity == Quantity::projection ||
         m.quantity == Quantity::focal || m.quantity == Quantity::focals;
}

// "stereo: [{R, T}, {R, T}]" of three cameras: pose 0 is not camera 0's.
bool numbers_pairs(const std::vector<KeyEntry>& entries, const std::set<int>& cameras) {
  std::set<int> poses;
  for (const KeyEntry& entry : entries) {
    const KeyMeaning& m = entry.meaning;
    const bool pose = m.quantity == Quantity::translation || m.quantity == Quantity::pose;
    if (pose && m.side == KeySide::none && m.number) poses.insert(*m.number);
  }
  return cameras.size() > 2 && poses.count(*cameras.begin()) > 0 && poses.count(*cameras.rbegin()) == 0;
}

// "cam0: Kl, Kr": a number around both cameras is the rig's.
void forget_numbers_of_rigs(std::vector<KeyEntry>& entries) {
  const auto outermost = [](const KeyEntry& entry) { return entry.key.substr(0, entry.key.find('.')); };
  std::set<std::string> with_left, with_right;
  for (const KeyEntry& entry : entries) {
    if (!entry.meaning.number || !is_of_a_camera(entry.meaning.quantity)) continue;
    if (entry.meaning.side == KeySide::left) with_left.insert(outermost(entry));
    if (entry.meaning.side == KeySide::right) with_right.insert(outermost(entry));
  }
  for (KeyEntry& entry : entries) {
    const std::string key = outermost(entry);
    const bool numbered = key.find_first_of("0123456789") != std::string::npos && key.size() < entry.key.size();
    if (numbered && with_left.count(key) > 0 && with_right.count(key) > 0) entry.meaning.number.reset();
  }
}

}  // namespace

// Which side a camera's number stands for: of two the smaller is the left one's; a single one beside none is the right.
void Keys::settle_numbers() {
  forget_numbers_of_rigs(entries_);
  std::set<int> numbers;
  bool plain = false;
  for (const KeyEntry& entry : entries_) {
    const KeyMeaning& m = entry.meaning;
    if (!is_of_numbered(m)) continue;
    if (m.side == KeySide::none && m.number) numbers.insert(*m.number);
    plain = plain || (m.side == KeySide::none && !m.number);
  }
  cameras_ = std::max(cameras_, static_cast<int>(numbers.size()));
  poses_are_of_others_ = poses_are_of_others_ || numbers_pairs(entries_, numbers);
  if (numbers.empty()) {
    for (const KeyEntry& entry : entries_) {  // an extrinsics file alone: R1, R2
      if (entry.meaning.side == KeySide::none && entry.meaning.number) numbers.insert(*entry.meaning.number);
    }
  }
  std::optional<int> left, right;
  if (numbers.size() >= 2) {
    left = *numbers.begin();
    right = *std::next(numbers.begin());
  } else if (numbers.size() == 1) {
    (plain && *numbers.begin() == 2 ? right : left) = *numbers.begin();
    if (left && *left < 2) right = *left + 1;
  }
  const bool plain_is_left = plain && right && !left;
  for (KeyEntry& entry : entries_) {
    KeyMeaning& m = entry.meaning;
    if (m.side != KeySide::none) continue;
    if (m.number && left && *m.number == *left) m.side = KeySide::left;
    if (m.number && right && *m.number == *right) m.side = KeySide::right;
    if (m.number && m.side == KeySide::none) m.quantity = Quantity::none;  // another camera's
    if (!m.number && plain_is_left && is_of_a_camera(m.quantity)) m.side = KeySide::left;
  }
}

}  // namespace cliquevo::drivers
