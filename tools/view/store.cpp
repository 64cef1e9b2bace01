// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/store.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace cliquevo::view {

namespace {

constexpr char kMagic[4] = {'C', 'V', 'F', '1'};
constexpr std::size_t kHead = 64;

int open_nameless(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0) return file;
  std::string name = folder + "/cliquevo-view-XXXXXX";  // file systems without O_TMPFILE
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

template <typename T>
void put(std::string& out, std::size_t at, T value) {
  std::memcpy(out.data() + at, &value, sizeof value);
}

}  // namespace

Result<std::unique_ptr<Store>> Store::make(std::int64_t most_bytes, std::size_t most_records) {
  const char* wanted = std::getenv("TMPDIR");
  const std::string folder = wanted != nullptr && *wanted != '\0' ? wanted : "/var/tmp";
  const int file = open_nameless(folder);
  if (file < 0) {
    return Error{"cannot make a file for pictures", folder, std::string(std::strerror(errno)) + "; set TMPDIR"};
  }
  return std::unique_ptr<Store>(new Store(file, most_bytes, most_records));
}

Store::Store(int file, std::int64_t most_bytes, std::size_t most_records)
    : file_(file), most_bytes_(most_bytes), most_records_(most_records) {}
Store::~Store() { ::close(file_); }

// The file is a ring; nothing in it goes over its end.
Store::Span Store::write(const Bytes& bytes) {
  const auto size = static_cast<std::int64_t>(bytes.size());
  if (size == 0 || size > most_bytes_ / 4) return {};
  const std::int64_t room = most_bytes_ - written_ % most_bytes_;
  if (room < size) written_ += room;
  const Span span{written_, static_cast<std::uint32_t>(size)};
  if (::pwrite(file_, bytes.data(), bytes.size(), written_ % most_bytes_) != size) {
    ++lost_pictures_;
    return {};
  }
  written_ += size;
  return span;
}

bool Store::read(const Span& span, char* to) const {
  if (written_ - span.begin > most_bytes_) return false;  // written over
  return ::pread(file_, to, span.size, span.begin % most_bytes_) == static_cast<ssize_t>(span.size);
}

void Store::add(const FrameFacts& facts, const FrameParts& parts) {
  const std::lock_guard lock(mutex_);
  Entry entry;
  entry.stamp_us = facts.stamp_us;
  entry.record = to_json(facts, first_ + static_cast<std::int64_t>(entries_.size()));
  const Bytes* all[] = {&parts.features, &parts.left, &parts.right, &parts.disparity};
  for (std::size_t k = 0; k < 4; ++k) entry.parts[k] = write(*all[k]);
  entry.disparity_step_px = parts.disparity_step_px;
  entries_.push_back(std::move(entry));
  if (entries_.size() > most_records_) {
    entries_.pop_front();
    ++first_;
  }
}

bool Store::add_pictures(std::int64_t stamp_us, const FrameParts& parts) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::find_if(entries_.rbegin(), entries_.rend(), [stamp_us](const Entry& e) { return e.stamp_us == stamp_us; });
  if (found == entries_.rend()) return false;
  const Bytes* all[] = {&parts.features, &parts.left, &parts.right, &parts.disparity};
  for (std::size_t k = 0; k < 4; ++k) {
    if (!all[k]->empty()) found->parts[k] = write(*all[k]);
  }
  if (!parts.disparity.empty()) found->disparity_step_px = parts.disparity_step_px;
  return true;
}

Store::Extent Store::extent() const {
  const std::lock_guard lock(mutex_);
  return {first_, first_ + static_cast<std::int64_t>(entries_.size()), lost_pictures_};
}

std::string Store::records(std::int64_t& from, std::size_t most) const {
  const std::lock_guard lock(mutex_);
  const std::int64_t end = first_ + static_cast<std::int64_t>(entries_.size());
  from = std::clamp(from, first_, end);
  std::string out;
  for (std::size_t k = 0; k < most && from < end; ++k, ++from) {
    if (!out.empty()) out += ',';
    out += entries_[static_cast<std::size_t>(from - first_)].record;
  }
  return out;
}

// Of a daemon pictures come more seldom than frames.
std::size_t Store::last_with_picture(std::size_t at) const {
  constexpr std::size_t kFarthest = 150;
  for (std::size_t back = 0; back <= std::min(at, kFarthest); ++back) {
    if (entries_[at - back].parts[1].size > 0) return at - back;
  }
  return at;
}

std::string Store::frame_message(std::int64_t number, unsigned parts, std::int64_t have) const {
  std::string out(kHead, '\0');
  std::memcpy(out.data(), kMagic, sizeof kMagic);
  put(out, 4, static_cast<std::uint32_t>(number));
  const std::lock_guard lock(mutex_);
  if (number < first_ || number >= first_ + static_cast<std::int64_t>(entries_.size())) return out;
  const auto at_number = static_cast<std::size_t>(number - first_);
  const std::size_t pictured = last_with_picture(at_number);
  if (have == first_ + static_cast<std::int64_t>(pictured)) parts &= kFeatures;
  put(out, 24, entries_[pictured].disparity_step_px);
  put(out, 28, static_cast<std::uint32_t>(first_ + static_cast<std::int64_t>(pictured)));
  for (std::size_t k = 0; k < 4; ++k) {
    const Span& span = entries_[k == 0 ? at_number : pictured].parts[k];
    if ((parts & (1U << k)) == 0 || span.size == 0) continue;
    const std::size_t at = out.size();
    out.resize(at + span.size);
    if (read(span, out.data() + at)) {
      put(out, 8 + 4 * k, span.size);
    } else {
      out.resize(at);
    }
  }
  return out;
}

}  // namespace cliquevo::view
