// SPDX-License-Identifier: BSD-3-Clause
// A YAML calibration file read with errors that name file, line and key; also OpenCV's and ROS's matrix maps.
#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"

namespace YAML {  // NOLINT(readability-identifier-naming)
class Node;
}

namespace cliquevo::drivers {

class YamlReader {
 public:
  // The first document of `text`, which must be a map; OpenCV's "%YAML:1.0" head is accepted.
  static Result<YamlReader> parse(std::string_view text, const std::string& path);

  const std::string& path() const { return path_; }
  bool has(std::string_view key) const;
  // The first of the names that is there; empty = none.
  std::string first_of(std::initializer_list<const char*> names) const;
  // The map below a key.
  Result<YamlReader> inner(const std::string& key) const;

  // A scalar as text; empty = not there.
  std::string word(const std::string& key) const;
  // All numbers of a scalar, a (nested) list, or a matrix map {rows, cols, data}, row-major. Errors: not there, not
  // finite, data not of rows x cols.
  Result<std::vector<double>> numbers(const std::string& key) const;
  // As numbers(), and there must be so many.
  Result<std::vector<double>> numbers(const std::string& key, std::size_t count) const;
  // A 4x4 matrix whose last row is 0 0 0 1.
  Result<RigidTransform> transform(const std::string& key) const;
  // width and height from two scalars or a list of two; nothing when no name is there.
  Result<std::optional<std::pair<int, int>>> image_size() const;

  // Where a key is, for messages: "file:12 (K1)".
  std::string where(const std::string& key) const;

 private:
  std::string path_;
  std::shared_ptr<const YAML::Node> node_;
};

}  // namespace cliquevo::drivers
