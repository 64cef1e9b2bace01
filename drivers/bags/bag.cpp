// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/bag.h"

#include <array>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "core/base/printable.h"
#include "drivers/bags/file_bytes.h"

namespace cliquevo::drivers {

namespace {

struct Container {
  std::string_view magic;
  Result<std::unique_ptr<Bag>> (*open)(const std::string& path);
};

constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};
constexpr std::array kContainers{Container{kMcapMagic, open_mcap}, Container{"#ROSBAG V", open_ros1_bag},
                                 Container{std::string_view("SQLite format 3\0", 16), open_sqlite_bag}};

const Container* container_of(const std::string& path) {
  std::error_code ec;
  if (!std::filesystem::is_regular_file(path, ec)) return nullptr;
  const auto file = FileBytes::open(path);
  if (!file) return nullptr;
  std::array<char, 16> begin{};
  for (const Container& container : kContainers) {
    if (file->read(0, begin.data(), container.magic.size()) &&
        container.magic == std::string_view(begin.data(), container.magic.size())) {
      return &container;
    }
  }
  return nullptr;
}

}  // namespace

std::uint32_t Bag::topic_number(BagTopic topic) {
  topic.name = printable(topic.name);  // they stand in messages
  topic.type = printable(topic.type);
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    if (topics_[i].name == topic.name && topics_[i].type == topic.type) return static_cast<std::uint32_t>(i);
  }
  topics_.push_back(std::move(topic));
  return static_cast<std::uint32_t>(topics_.size() - 1);
}

bool looks_like_bag(const std::string& path) { return container_of(path) != nullptr; }

Result<std::unique_ptr<Bag>> open_bag(const std::string& path) {
  const Container* container = container_of(path);
  if (container == nullptr) return Error{"no bag", path, "name a .mcap, .bag or .db3 file"};
  return container->open(path);
}

std::string plain_type(const std::string& name) {
  const std::size_t at = name.find("/msg/");
  return at == std::string::npos ? name : name.substr(0, at) + name.substr(at + 4);
}

}  // namespace cliquevo::drivers
