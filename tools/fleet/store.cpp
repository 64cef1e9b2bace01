// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/store.h"

#include <utility>

#include <fmt/format.h>

#include "tools/fleet/digest.h"

namespace cliquevo::tools::fleet {

namespace {

constexpr std::size_t kLargestResult = std::size_t{64} << 20U;
constexpr std::size_t kShelf = 2;  // digits

const char* name_of(Part part) { return part == Part::result ? "result" : part == Part::cost ? "cost" : "failure"; }

std::string file_of(const std::string& key, Part part) { return fmt::format("{}.{}.json", key, name_of(part)); }

// A line of JSON before the text, so that the file is two JSON values.
std::string head_of(const std::string& key, Part part, const std::string& text) {
  return fmt::format("{{\"cliquevo_fleet\":1,\"part\":\"{}\",\"key\":\"{}\",\"sha256\":\"{}\"}}\n", name_of(part), key,
                     sha256(text));
}

}  // namespace

Result<Store> Store::open(const std::string& path) {
  auto root = drivers::OwnFolder::open_shared(path);
  if (!root) return root.error();
  return Store(std::move(*root));
}

Result<drivers::OwnFolder*> Store::shelf(const std::string& key) {
  const std::string name = key.substr(0, kShelf);
  auto found = shelves_.find(name);
  if (found == shelves_.end()) {
    auto made = root_.below(name);
    if (!made) return made.error();
    found = shelves_.emplace(name, std::move(*made)).first;
  }
  return &found->second;
}

std::optional<std::string> Store::read(const std::string& key, Part part) {
  const auto folder = shelf(key);
  if (!folder) return std::nullopt;
  auto all = (*folder)->read(file_of(key, part), kLargestResult);
  const std::size_t end = all ? all->find('\n') : std::string::npos;
  if (end == std::string::npos) return std::nullopt;
  const std::string text = all->substr(end + 1);
  if (all->substr(0, end + 1) != head_of(key, part, text)) return std::nullopt;
  return text;
}

std::optional<std::int64_t> Store::written_ns(const std::string& key, Part part) {
  const auto folder = shelf(key);
  if (!folder) return std::nullopt;
  return (*folder)->written_ns(file_of(key, part));
}

Result<void> Store::write(const std::string& key, Part part, const std::string& text) {
  const auto folder = shelf(key);
  if (!folder) return folder.error();
  return (*folder)->write(file_of(key, part), head_of(key, part, text) + text);
}

std::string Store::trajectory_path(const std::string& key) const {
  return fmt::format("{}/{}/{}.poses.txt", path(), key.substr(0, kShelf), key);
}

Result<void> Store::write_trajectory(const std::string& key, const std::string& text) {
  const auto folder = shelf(key);
  if (!folder) return folder.error();
  return (*folder)->write(key + ".poses.txt", text);
}

void Store::forget(const std::string& key, Part part) {
  if (const auto folder = shelf(key)) (*folder)->remove(file_of(key, part));
}

Result<void> Store::probe() {
  constexpr std::size_t kRoom = 65536;
  auto written = root_.write("room", std::string(kRoom, ' '));
  root_.remove("room");
  return written;
}

}  // namespace cliquevo::tools::fleet
