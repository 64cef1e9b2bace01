// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/bag_set.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "drivers/recording/layout.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

Result<BagSet> BagSet::open(const std::vector<std::string>& paths) {
  BagSet set;
  for (const std::string& path : paths) {
    auto bag = open_bag(path);
    if (!bag) return bag.error();
    set.files_.push_back(std::move(*bag));
  }
  std::stable_sort(set.files_.begin(), set.files_.end(), [](const auto& a, const auto& b) {
    return a->messages().front().received_ns < b->messages().front().received_ns;
  });
  for (const std::unique_ptr<Bag>& bag : set.files_) {
    std::vector<std::int64_t> counts(bag->topics().size());
    for (const BagMessage& message : bag->messages()) ++counts[message.topic];
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const BagTopic& topic = bag->topics()[i];
      auto known = std::find_if(set.topics_.begin(), set.topics_.end(), [&](const SetTopic& t) {
        return t.topic.name == topic.name && t.topic.type == topic.type;
      });
      if (known == set.topics_.end()) known = set.topics_.insert(set.topics_.end(), {topic, 0});
      known->count += counts[i];
    }
  }
  return set;
}

const SetTopic* BagSet::find(const std::string& name) const {
  for (const SetTopic& topic : topics_) {
    if (topic.topic.name == name) return &topic;
  }
  return nullptr;
}

std::vector<SetMessage> BagSet::messages_of(const std::string& topic) const {
  std::vector<SetMessage> out;
  for (std::size_t file = 0; file < files_.size(); ++file) {
    for (const BagMessage& message : files_[file]->messages()) {
      if (files_[file]->topics()[message.topic].name == topic) out.push_back({file, message});
    }
  }
  return out;
}

std::string BagSet::describe(const std::string& path) const {
  std::string out = fmt::format("{} {}", files_.front()->kind(), path);
  if (files_.size() > 1) out += fmt::format(" ({} files)", files_.size());
  for (const std::unique_ptr<Bag>& bag : files_) {
    if (bag->damage().empty()) continue;
    out +=
        files_.size() > 1 ? fmt::format(" ({}: {})", bag->path(), bag->damage()) : fmt::format(" ({})", bag->damage());
  }
  return out;
}

std::vector<std::string> find_bags(const std::string& path) {
  std::error_code ec;
  if (fs::is_regular_file(path, ec)) {
    return looks_like_bag(path) ? std::vector<std::string>{path} : std::vector<std::string>{};
  }
  std::vector<std::string> bags;
  for (fs::directory_iterator entry(path, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    const std::string extension = entry->path().extension().string();
    const bool named_so = extension == ".mcap" || extension == ".bag" || extension == ".db3";
    if (named_so && looks_like_bag(entry->path().string())) bags.push_back(entry->path().string());
  }
  std::sort(bags.begin(), bags.end(), natural_less);
  return bags;
}

}  // namespace cliquevo::drivers
