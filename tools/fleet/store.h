// SPDX-License-Identifier: BSD-3-Clause
// The results, a few files a unit, named by its key: the only state that a fleet has. Safe for any number of processes
// on any number of machines at once; what is read back was written by this user and is whole (own_folder.h, and the
// hash in the first line).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "drivers/own_folder.h"

namespace cliquevo::tools::fleet {

enum class Part {
  result,   // the same bytes wherever and whenever it was computed
  cost,     // what it took: host, seconds
  failure,  // why there is no result; void where there is one
};

class Store {
 public:
  // In a folder that others may write into, ours is user-UID there.
  static Result<Store> open(const std::string& path);

  const std::string& path() const { return root_.path(); }
  // The JSON text of a part; nothing: none there, or it cannot be trusted.
  std::optional<std::string> read(const std::string& key, Part part);
  // When the part was written, ns since 1970, without looking into it.
  std::optional<std::int64_t> written_ns(const std::string& key, Part part);
  // text: JSON, one line. Error: the disk is full, ...
  Result<void> write(const std::string& key, Part part, const std::string& text);
  Result<void> write_trajectory(const std::string& key, const std::string& text);
  std::string trajectory_path(const std::string& key) const;
  void forget(const std::string& key, Part part);
  // Whether there is room for one more result.
  Result<void> probe();

 private:
  explicit Store(drivers::OwnFolder root) : root_(std::move(root)) {}
  Result<drivers::OwnFolder*> shelf(const std::string& key);

  drivers::OwnFolder root_;
  std::map<std::string, drivers::OwnFolder> shelves_;  // by the key's first two digits
};

}  // namespace cliquevo::tools::fleet
