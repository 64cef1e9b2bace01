// SPDX-License-Identifier: BSD-3-Clause
// The keys of a calibration file (or of two that belong together) by what they mean.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/calibration/document.h"
#include "drivers/calibration/key_names.h"

namespace cliquevo::drivers {

struct KeyEntry {
  std::string key;  // as in the file, with dots
  std::string where;
  KeyMeaning meaning;
  std::vector<double> numbers;
  std::string word;
  std::optional<Error> error;  // of its numbers
};

class Keys {
 public:
  Keys() = default;
  explicit Keys(const Document& document) { add(document); }

  void add(const Document& document);
  // The one of this side; of neither where it is none; nullptr = there is none. An Error where two differ.
  Result<const KeyEntry*> find(Quantity quantity, KeySide side, int index = 0) const;
  // All words that name a lens, for a camera or for both.
  std::vector<const KeyEntry*> lenses(KeySide side) const;
  bool has(Quantity quantity, KeySide side) const;
  bool has(Quantity quantity) const;
  // How many cameras have numbers, of which two are taken; and whether poses are numbered otherwise than cameras.
  int cameras() const { return cameras_; }
  bool poses_are_of_others() const { return poses_are_of_others_; }

 private:
  void walk(const DocumentNode& node, const std::string& file, const std::string& key, std::vector<std::string>& path);
  void step(const DocumentNode& inner, const std::string& file, const std::string& key, const std::string& name,
            std::vector<std::string>& path);
  void leaf(const DocumentNode& node, const std::string& file, const std::string& key,
            const std::vector<std::string>& path);
  void settle_numbers();

  std::vector<KeyEntry> entries_;
  int cameras_ = 0;
  bool poses_are_of_others_ = false;
};

}  // namespace cliquevo::drivers
