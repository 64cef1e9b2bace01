// SPDX-License-Identifier: BSD-3-Clause
// The bags of one recording as one: topics of the same name and type are one topic.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/bags/bag.h"

namespace cliquevo::drivers {

struct SetMessage {
  std::size_t file = 0;
  BagMessage message;
};

struct SetTopic {
  BagTopic topic;
  std::int64_t count = 0;
};

class BagSet {
 public:
  // In the order of their first messages.
  static Result<BagSet> open(const std::vector<std::string>& paths);

  const std::vector<SetTopic>& topics() const { return topics_; }
  const std::vector<std::unique_ptr<Bag>>& files() const { return files_; }
  // The topic of this name; nullptr = there is none.
  const SetTopic* find(const std::string& name) const;
  // Of the topic, in the order in which they were written.
  std::vector<SetMessage> messages_of(const std::string& topic) const;
  const BagTopic& topic_of(const SetMessage& m) const { return files_[m.file]->topics()[m.message.topic]; }
  Result<void> read(const SetMessage& m, std::vector<std::uint8_t>& out, std::size_t most = SIZE_MAX) {
    return files_[m.file]->read(m.message, out, most);
  }
  // "MCAP bag drive.mcap (cut off: ...)".
  std::string describe(const std::string& path) const;

 private:
  std::vector<std::unique_ptr<Bag>> files_;
  std::vector<SetTopic> topics_;
};

// The bags that a path means: itself, or those in the folder; empty = it means something else.
std::vector<std::string> find_bags(const std::string& path);

}  // namespace cliquevo::drivers
