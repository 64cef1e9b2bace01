// SPDX-License-Identifier: BSD-3-Clause
// A calibration file with keys, whatever its syntax (YAML, JSON, OpenCV's XML, INI): a tree with the line of each node,
// read with errors that name file, line and key.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"

namespace cliquevo::drivers {

struct DocumentEntry;

struct DocumentNode {
  enum class Kind { absent, empty, scalar, list, map };
  Kind kind = Kind::absent;
  int line = 0;  // from 1; 0 = not known
  std::string scalar;
  std::vector<DocumentNode> items;     // of a list
  std::vector<DocumentEntry> entries;  // of a map, as they stand in the file

  const DocumentNode* find(std::string_view key) const;
};

struct DocumentEntry {
  std::string name;
  DocumentNode node;
};

class Document {
 public:
  // Each takes the whole text; a file that is none of its syntax is an Error. `parse_yaml` takes JSON too, and what
  // OpenCV writes and reads though YAML does not: "%YAML:1.0" heads, "data:[" without a blank.
  static Result<Document> parse_yaml(std::string_view text, const std::string& path);
  static Result<Document> parse_xml(std::string_view text, const std::string& path);
  // [section] and key=value or key: value; keys before a section stand at the top.
  static Result<Document> parse_ini(std::string_view text, const std::string& path);
  // What programs print: "name = [1 2 3]", or numbers in the lines below "name:"; names without numbers are sections.
  static Result<Document> parse_printed(std::string_view text, const std::string& path);
  // NumPy's archive (.npz), as bytes: its arrays by their names. Large ones are passed over.
  static Result<Document> parse_numpy(std::string_view bytes, const std::string& path);
  static Document of(DocumentNode root, std::string path);

  const std::string& path() const { return path_; }
  const DocumentNode& root() const { return root_; }
  bool has(std::string_view key) const;
  // The first of the names that is there; empty = none.
  std::string first_of(std::initializer_list<const char*> names) const;
  // The map below a key.
  Result<Document> inner(const std::string& key) const;
  // The maps of a list below a key; empty = there is no such list.
  std::vector<Document> list(const std::string& key) const;

  // A scalar as text; empty = not there.
  std::string word(const std::string& key) const;
  // All numbers of a scalar, a (nested) list, or a matrix map {rows, cols, data}, row-major. Errors: not there, not
  // finite, data not of rows x cols.
  Result<std::vector<double>> numbers(const std::string& key) const;
  // As numbers(), and there must be so many.
  Result<std::vector<double>> numbers(const std::string& key, std::size_t count) const;
  Result<double> number(const std::string& key) const;
  // A 4x4 matrix whose last row is 0 0 0 1.
  Result<RigidTransform> transform(const std::string& key) const;
  // width and height from two scalars or a list of two; nothing when no name is there.
  Result<std::optional<std::pair<int, int>>> image_size() const;

  // Where a key is, for messages: "file:12 (K1)".
  std::string where(const std::string& key) const;
  // The first keys of the file, for messages: "a, b, c ...".
  std::string keys_found() const;

 private:
  std::string path_;
  DocumentNode root_;
};

// The numbers of a node as Document::numbers() has them.
Result<std::vector<double>> numbers_of(const DocumentNode& node, const std::string& where);
// A 4x4 (or 3x4) matrix in row-major numbers as a rigid transform; 4x4 numbers of the transpose show by their column.
Result<RigidTransform> transform_from(const std::vector<double>& row_major, const std::string& where);
Result<std::pair<int, int>> size_from(double width, double height, const std::string& where);

}  // namespace cliquevo::drivers
