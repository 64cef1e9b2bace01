// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/yaml_reader.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "drivers/recording/calibration_common.h"
#include "drivers/recording/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr std::size_t kMostNumbers = 1000;  // no calibration has more in one place

// Where the map has no such key the result is not defined. A lookup by operator[] would add the key.
YAML::Node find(const YAML::Node& map, std::string_view key) {
  if (map.IsMap()) {
    for (const auto& entry : map) {
      if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.second;
    }
  }
  return YAML::Node(YAML::NodeType::Undefined);
}

std::string place(const std::string& path, const YAML::Node& node, std::string_view key) {
  const int line = node.IsDefined() ? node.Mark().line + 1 : 0;
  return line > 0 ? fmt::format("{}:{} ({})", path, line, key) : fmt::format("{} ({})", path, key);
}

Result<void> collect(const YAML::Node& node, const std::string& where, int depth, std::vector<double>& out) {
  if (node.IsScalar()) {
    const Result<std::vector<double>> values = parse_numbers(node.Scalar(), "calibration", where);
    if (!values) return values.error();
    out.insert(out.end(), values->begin(), values->end());
    return {};
  }
  if (!node.IsSequence() || depth > 2 || node.size() > kMostNumbers || out.size() > kMostNumbers) {
    return Error{"calibration holds no list of numbers", where, "put numbers there"};
  }
  for (const YAML::Node& item : node) {
    if (Result<void> ok = collect(item, where, depth + 1, out); !ok) return ok;
  }
  return {};
}

}  // namespace

Result<YamlReader> YamlReader::parse(std::string_view text, const std::string& path) {
  // "%YAML:1.0" is no directive that YAML knows; blanks keep the line numbers.
  std::string clean(text);
  if (clean.compare(0, 5, "%YAML") == 0) {
    for (std::size_t i = 0; i < clean.size() && clean[i] != '\n'; ++i) clean[i] = ' ';
  }
  YamlReader reader;
  reader.path_ = path;
  try {
    const YAML::Node node = YAML::Load(clean);
    if (!node.IsMap()) return Error{"calibration is of no known format", path, "expected YAML with keys and values"};
    reader.node_ = std::make_shared<const YAML::Node>(node);
  } catch (const YAML::Exception& e) {
    return Error{"calibration is no valid YAML (" + printable(e.msg) + ")", fmt::format("{}:{}", path, e.mark.line + 1),
                 "copy it again: it may be torn"};
  }
  return reader;
}

bool YamlReader::has(std::string_view key) const { return find(*node_, key).IsDefined(); }

std::string YamlReader::first_of(std::initializer_list<const char*> names) const {
  for (const char* name : names) {
    if (has(name)) return name;
  }
  return {};
}

Result<YamlReader> YamlReader::inner(const std::string& key) const {
  const YAML::Node node = find(*node_, key);
  if (!node.IsDefined() || !node.IsMap()) {
    return Error{"calibration lacks " + key, path_, "copy it again or name the right file"};
  }
  YamlReader reader;
  reader.path_ = path_;
  reader.node_ = std::make_shared<const YAML::Node>(node);
  return reader;
}

std::string YamlReader::word(const std::string& key) const {
  const YAML::Node node = find(*node_, key);
  return node.IsDefined() && node.IsScalar() ? node.Scalar() : std::string{};
}

std::string YamlReader::where(const std::string& key) const { return place(path_, find(*node_, key), key); }

Result<std::vector<double>> YamlReader::numbers(const std::string& key) const {
  const YAML::Node node = find(*node_, key);
  if (!node.IsDefined()) return Error{"calibration lacks " + key, path_, "copy it again or name the right file"};
  std::vector<double> values;
  if (!node.IsMap()) {
    if (node.IsNull()) return values;
    if (const Result<void> ok = collect(node, where(key), 0, values); !ok) return ok.error();
    return values;
  }
  const YAML::Node data = find(node, "data");
  if (!data.IsDefined()) return Error{"matrix has no data", where(key), "copy the calibration again: it is torn"};
  if (!data.IsNull()) {
    if (const Result<void> ok = collect(data, where(key), 0, values); !ok) return ok.error();
  }
  double cells = 1.0;
  for (const char* side : {"rows", "cols"}) {
    const YAML::Node count = find(node, side);
    if (!count.IsDefined()) return values;  // EuRoC and ROS may leave them out
    const std::optional<double> n = count.IsScalar() ? parse_number(count.Scalar()) : std::nullopt;
    if (!n) return Error{"matrix has no number of rows or columns", where(key), "correct rows and cols"};
    cells *= *n;
  }
  if (cells != static_cast<double>(values.size())) {
    return Error{fmt::format("matrix has {} numbers instead of {:.6g}", values.size(), cells), where(key),
                 "copy the calibration again: it is torn"};
  }
  return values;
}

Result<std::vector<double>> YamlReader::numbers(const std::string& key, std::size_t count) const {
  Result<std::vector<double>> values = numbers(key);
  if (values && values->size() != count) {
    return Error{fmt::format("{} has {} numbers instead of {}", key, values->size(), count), where(key),
                 "copy the calibration again: it is torn"};
  }
  return values;
}

Result<RigidTransform> YamlReader::transform(const std::string& key) const {
  const Result<std::vector<double>> read = numbers(key, 16);
  if (!read) return read.error();
  const std::vector<double>& v = *read;
  if (v[12] != 0.0 || v[13] != 0.0 || v[14] != 0.0 || v[15] != 1.0) {
    return calibration_error("transform's last row is not 0 0 0 1", where(key));
  }
  RigidTransform T;
  T.R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  T.t = {v[3], v[7], v[11]};
  if (const Result<void> ok = check_rotation(T.R, where(key)); !ok) return ok.error();
  return T;
}

Result<std::optional<std::pair<int, int>>> YamlReader::image_size() const {
  using Size = std::optional<std::pair<int, int>>;
  std::vector<double> size;
  const std::string list =
      first_of({"resolution", "image_size", "imageSize", "img_size", "image_resolution", "size", "imgSize"});
  if (!list.empty()) {
    const Result<std::vector<double>> read = numbers(list, 2);
    if (!read) return read.error();
    size = *read;
  } else {
    const std::string width = first_of({"image_width", "width", "imageWidth", "Camera.width"});
    const std::string height = first_of({"image_height", "height", "imageHeight", "Camera.height"});
    if (width.empty() || height.empty()) return Size{};
    for (const std::string& key : {width, height}) {
      const Result<std::vector<double>> read = numbers(key, 1);
      if (!read) return read.error();
      size.push_back(read.value()[0]);
    }
  }
  for (const double side : size) {
    if (side < 16.0 || side > 16384.0 || side != static_cast<int>(side)) {
      return calibration_error("image size is absurd", path_);
    }
  }
  return Size{{static_cast<int>(size[0]), static_cast<int>(size[1])}};
}

}  // namespace cliquevo::drivers
