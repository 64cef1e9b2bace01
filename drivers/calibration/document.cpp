// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/document.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr std::size_t kMostNumbers = 1000;  // no calibration has more in one place
constexpr double kMostValue = 1e9;          // no value of a calibration is beyond

const DocumentNode kAbsent;

std::string place(const std::string& path, const DocumentNode& node, std::string_view raw_key) {
  const std::string key = printable(raw_key.substr(0, 64));
  return node.line > 0 ? fmt::format("{}:{} ({})", path, node.line, key) : fmt::format("{} ({})", path, key);
}

Result<void> collect(const DocumentNode& node, const std::string& where, int depth, std::vector<double>& out) {
  if (node.kind == DocumentNode::Kind::scalar) {
    std::string text = node.scalar;
    if (text.starts_with("[")) {  // a matrix as numpy prints it
      std::replace_if(
          text.begin(), text.end(), [](char c) { return c == '[' || c == ']' || c == '\n'; }, ' ');
    }
    const Result<std::vector<double>> values = parse_numbers(text, "calibration", where);
    if (!values) return values.error();
    for (const double value : *values) {
      if (!(std::abs(value) <= kMostValue)) {
        return calibration_error(fmt::format("calibration holds {:.3g}, which is absurd", value), where);
      }
    }
    out.insert(out.end(), values->begin(), values->end());
    return {};
  }
  if (node.kind != DocumentNode::Kind::list || depth > 2 || node.items.size() > kMostNumbers ||
      out.size() > kMostNumbers) {
    return Error{"calibration holds no list of numbers", where, "put numbers there"};
  }
  for (const DocumentNode& item : node.items) {
    if (Result<void> ok = collect(item, where, depth + 1, out); !ok) return ok;
  }
  return {};
}

}  // namespace

const DocumentNode* DocumentNode::find(std::string_view key) const {
  for (const auto& [name, node] : entries) {
    if (name == key) return &node;
  }
  return nullptr;
}

Document Document::of(DocumentNode root, std::string path) {
  Document out;
  out.path_ = std::move(path);
  out.root_ = std::move(root);
  return out;
}

bool Document::has(std::string_view key) const { return root_.find(key) != nullptr; }

std::string Document::first_of(std::initializer_list<const char*> names) const {
  for (const char* name : names) {
    if (has(name)) return name;
  }
  return {};
}

Result<Document> Document::inner(const std::string& key) const {
  const DocumentNode* node = root_.find(key);
  if (node == nullptr || node->kind != DocumentNode::Kind::map) {
    return Error{"calibration lacks " + key, path_, "copy it again or name the right file"};
  }
  return of(*node, path_);
}

std::vector<Document> Document::list(const std::string& key) const {
  std::vector<Document> out;
  const DocumentNode* node = root_.find(key);
  if (node == nullptr) return out;
  for (const DocumentNode& item : node->items) out.push_back(of(item, path_));
  return out;
}

std::string Document::word(const std::string& key) const {
  const DocumentNode* node = root_.find(key);
  return node != nullptr && node->kind == DocumentNode::Kind::scalar ? node->scalar : std::string{};
}

std::string Document::where(const std::string& key) const {
  const DocumentNode* node = root_.find(key);
  return place(path_, node != nullptr ? *node : kAbsent, key);
}

std::string Document::keys_found() const {
  std::string out;
  std::size_t count = 0;
  for (const auto& [name, node] : root_.entries) {
    if (count++ == 8) return out + " ...";
    out += (out.empty() ? "" : ", ") + printable(name.substr(0, 32));
  }
  return out.empty() ? "no keys" : out;
}

Result<std::vector<double>> numbers_of(const DocumentNode& node, const std::string& where) {
  std::vector<double> values;
  if (node.kind != DocumentNode::Kind::map) {
    if (node.kind == DocumentNode::Kind::empty) return values;
    if (const Result<void> ok = collect(node, where, 0, values); !ok) return ok.error();
    return values;
  }
  const DocumentNode* data = node.find("data");
  if (data == nullptr) return Error{"matrix has no data", where, "copy the calibration again: it is torn"};
  if (data->kind != DocumentNode::Kind::empty) {
    if (const Result<void> ok = collect(*data, where, 0, values); !ok) return ok.error();
  }
  if (values.empty()) return values;  // whatever its rows and columns: nothing was written
  double cells = 1.0;
  for (const char* side : {"rows", "cols"}) {
    const DocumentNode* count = node.find(side);
    if (count == nullptr) return values;  // EuRoC and ROS may leave them out
    const std::optional<double> n = parse_number(trim(count->scalar));
    if (!n) return Error{"matrix has no number of rows or columns", where, "correct rows and cols"};
    cells *= *n;
  }
  if (cells != static_cast<double>(values.size())) {
    return Error{fmt::format("matrix has {} numbers instead of {:.6g}", values.size(), cells), where,
                 "copy the calibration again: it is torn"};
  }
  return values;
}

Result<std::vector<double>> Document::numbers(const std::string& key) const {
  const DocumentNode* node = root_.find(key);
  if (node == nullptr) return Error{"calibration lacks " + key, path_, "copy it again or name the right file"};
  return numbers_of(*node, where(key));
}

Result<std::vector<double>> Document::numbers(const std::string& key, std::size_t count) const {
  Result<std::vector<double>> values = numbers(key);
  if (values && values->size() != count) {
    return Error{fmt::format("{} has {} numbers instead of {}", key, values->size(), count), where(key),
                 "copy the calibration again: it is torn"};
  }
  return values;
}

Result<double> Document::number(const std::string& key) const {
  const Result<std::vector<double>> value = numbers(key, 1);
  if (!value) return value.error();
  return value->front();
}

Result<RigidTransform> transform_from(const std::vector<double>& v, const std::string& where) {
  if (v.size() != 16 && v.size() != 12) {
    return Error{fmt::format("transform has {} numbers instead of 16", v.size()), where,
                 "copy the calibration again: it is torn"};
  }
  const bool transposed = v.size() == 16 && v[3] == 0.0 && v[7] == 0.0 && v[11] == 0.0 && v[15] == 1.0 &&
                          (v[12] != 0.0 || v[13] != 0.0 || v[14] != 0.0);
  if (transposed) {
    return transform_from({v[0], v[4], v[8], v[12], v[1], v[5], v[9], v[13], v[2], v[6], v[10], v[14]}, where);
  }
  if (v.size() == 16 && (v[12] != 0.0 || v[13] != 0.0 || v[14] != 0.0 || v[15] != 1.0)) {
    return calibration_error("transform's last row is not 0 0 0 1", where);
  }
  RigidTransform T;
  T.R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  T.t = {v[3], v[7], v[11]};
  if (const Result<void> ok = check_rotation(T.R, where); !ok) return ok.error();
  return T;
}

Result<RigidTransform> Document::transform(const std::string& key) const {
  Result<std::vector<double>> read = numbers(key);
  if (read && read->size() != 12) read = numbers(key, 16);
  if (!read) return read.error();
  return transform_from(*read, where(key));
}

Result<std::pair<int, int>> size_from(double width, double height, const std::string& where) {
  for (const double side : {width, height}) {
    if (!(side >= 16.0 && side <= 16384.0) || side != static_cast<int>(side)) {
      return calibration_error("image size is absurd", where);
    }
  }
  return std::pair<int, int>{static_cast<int>(width), static_cast<int>(height)};
}

Result<std::optional<std::pair<int, int>>> Document::image_size() const {
  using Size = std::optional<std::pair<int, int>>;
  const std::string list = first_of(
      {"resolution", "image_size", "imageSize", "img_size", "image_resolution", "size", "imgSize", "image_dimension"});
  std::vector<double> size;
  if (!list.empty()) {
    const Result<std::vector<double>> read = numbers(list, 2);
    if (!read) return read.error();
    size = *read;
  } else {
    const std::string width = first_of({"image_width", "width", "imageWidth", "Camera.width"});
    const std::string height = first_of({"image_height", "height", "imageHeight", "Camera.height"});
    if (width.empty() || height.empty()) return Size{};
    for (const std::string& key : {width, height}) {
      const Result<double> read = number(key);
      if (!read) return read.error();
      size.push_back(*read);
    }
  }
  const auto checked = size_from(size[0], size[1], path_);
  if (!checked) return checked.error();
  return Size{*checked};
}

}  // namespace cliquevo::drivers
