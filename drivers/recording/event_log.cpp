// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/event_log.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "drivers/bytes.h"

namespace cliquevo::drivers {

namespace {

// An event is: this number, its own number (8 bytes), its time (8), lengths of channel and data (4 each), channel,
// data.
constexpr std::uint32_t kMagic = 0xEDA1DA01;
constexpr std::int64_t kHeader = 28;
constexpr std::int32_t kLongestChannel = 255;
constexpr std::size_t kWindow = 1 << 16;
constexpr const char* kThereAlready = "it is there already: name a new file";

bool write_all(int descriptor, const std::uint8_t* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

// The beginning of an event, if `head` is one and can end within `left` bytes.
std::optional<LoggedEvent> event_at(std::int64_t at, const std::uint8_t* head, std::size_t head_size, std::int64_t left,
                                    std::int32_t& channel_size) {
  ByteReader reader(head, head_size);
  const auto magic = reader.number<std::uint32_t>();
  reader.number<std::int64_t>();
  LoggedEvent event;
  event.utime = reader.number<std::int64_t>();
  channel_size = reader.number<std::int32_t>();
  event.size = reader.number<std::int32_t>();
  event.data_at = at + kHeader + channel_size;
  const bool sane = reader.ok() && magic == kMagic && channel_size > 0 && channel_size <= kLongestChannel &&
                    event.size >= 0 && kHeader + channel_size + event.size <= left;
  return sane ? std::optional(event) : std::nullopt;
}

}  // namespace

struct EventLogWriter::Impl {
  ~Impl() {
    if (descriptor >= 0) ::close(descriptor);
  }
  int descriptor = -1;
  std::string path;
  std::int64_t bytes = 0;
  std::int64_t events = 0;
  std::vector<std::uint8_t> head;  // of the event in work
};

EventLogWriter::EventLogWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EventLogWriter::EventLogWriter(EventLogWriter&&) noexcept = default;
EventLogWriter& EventLogWriter::operator=(EventLogWriter&&) noexcept = default;
EventLogWriter::~EventLogWriter() = default;
std::int64_t EventLogWriter::bytes() const { return impl_->bytes; }
const std::string& EventLogWriter::path() const { return impl_->path; }

Result<EventLogWriter> EventLogWriter::create(const std::string& path) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640);
  if (impl->descriptor < 0) {
    if (errno == EEXIST) return Error{"cannot write log", path, kThereAlready};
    return Error{"cannot write log", path, std::string(std::strerror(errno)) + ": name a file in a folder of yours"};
  }
  return EventLogWriter(std::move(impl));
}

Result<void> EventLogWriter::write(const std::string& channel, const std::uint8_t* data, std::size_t size,
                                   std::int64_t utime) {
  Impl& m = *impl_;
  if (m.descriptor < 0) return Error{"cannot write log", m.path, "an earlier event did not fit"};
  if (size > INT32_MAX || channel.size() > static_cast<std::size_t>(kLongestChannel)) {
    return Error{"cannot write log", m.path, "an event is too large for a log"};
  }
  m.head.clear();
  put_number(m.head, kMagic);
  put_number(m.head, m.events);
  put_number(m.head, utime);
  put_number(m.head, static_cast<std::int32_t>(channel.size()));
  put_number(m.head, static_cast<std::int32_t>(size));
  m.head.insert(m.head.end(), channel.begin(), channel.end());
  if (!write_all(m.descriptor, m.head.data(), m.head.size()) || !write_all(m.descriptor, data, size)) {
    const std::string why = std::strerror(errno);
    const bool cut = ::ftruncate(m.descriptor, m.bytes) == 0;  // behind the last whole event
    ::close(std::exchange(m.descriptor, -1));
    return Error{"cannot write log", m.path,
                 why + (cut ? ": it holds everything before" : ": its last event is torn") + "; free some space"};
  }
  ++m.events;
  m.bytes += static_cast<std::int64_t>(m.head.size() + size);
  return {};
}

EventLogReader::EventLogReader(int descriptor, std::int64_t size, std::string path)
    : descriptor_(descriptor), size_(size), path_(std::move(path)) {}
EventLogReader::EventLogReader(EventLogReader&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_), path_(std::move(other.path_)) {}
EventLogReader& EventLogReader::operator=(EventLogReader&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(path_, other.path_);
  return *this;
}
EventLogReader::~EventLogReader() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<EventLogReader> EventLogReader::open(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return Error{"cannot read log", path, std::strerror(errno)};
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor);
    return Error{"cannot read log", path, "it is no ordinary file"};
  }
  return EventLogReader(descriptor, status.st_size, path);
}

bool EventLogReader::read_at(std::int64_t at, void* out, std::size_t size) const {
  auto* to = static_cast<std::uint8_t*>(out);
  while (size > 0) {
    const ssize_t got = ::pread(descriptor_, to, size, at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return {};
    to += got;
    at += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

LogDamage EventLogReader::scan(const std::function<void(std::string_view, const LoggedEvent&)>& on_event) const {
  LogDamage damage;
  std::int64_t whole_until = 0;
  std::vector<std::uint8_t> window(kWindow);  // what is in memory of the file, from window_at on
  std::int64_t window_at = 0;
  std::size_t window_size = 0;
  bool broken = false;  // looking for the next event
  for (std::int64_t at = 0; at < size_;) {
    const auto needed = static_cast<std::size_t>(std::min<std::int64_t>(size_ - at, kHeader + kLongestChannel));
    if (at < window_at || at + static_cast<std::int64_t>(needed) > window_at + static_cast<std::int64_t>(window_size)) {
      // Behind an event only its neighbour's head is wanted; where one is looked for, all that comes.
      window_at = at;
      window_size = broken ? static_cast<std::size_t>(std::min<std::int64_t>(size_ - at, kWindow)) : needed;
      if (!read_at(at, window.data(), window_size)) break;
    }
    const std::uint8_t* here = &window[static_cast<std::size_t>(at - window_at)];
    const std::size_t in_memory = window_size - static_cast<std::size_t>(at - window_at);
    std::int32_t channel_size = 0;
    const auto event = event_at(at, here, needed, size_ - at, channel_size);
    if (!event) {
      broken = true;
      const void* next = in_memory > 1 ? std::memchr(here + 1, kMagic >> 24U, in_memory - 1) : nullptr;
      at += next == nullptr ? static_cast<std::int64_t>(in_memory) : static_cast<const std::uint8_t*>(next) - here;
      continue;
    }
    if (std::exchange(broken, false)) ++damage.broken_places;
    on_event({reinterpret_cast<const char*>(here) + kHeader, static_cast<std::size_t>(channel_size)}, *event);
    at = event->data_at + event->size;
    whole_until = at;
  }
  damage.torn_tail = size_ - whole_until;
  return damage;
}

Result<void> EventLogReader::read(const LoggedEvent& event, std::vector<std::uint8_t>& out, std::size_t most) const {
  out.resize(std::min(most, static_cast<std::size_t>(event.size)));
  if (!read_at(event.data_at, out.data(), out.size())) {
    return Error{"cannot read log", path_, "the file changed while it was read"};
  }
  return {};
}

std::string first_channel(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return {};
  struct stat status = {};
  std::array<std::uint8_t, kHeader + kLongestChannel> head{};
  const bool ordinary = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  const ssize_t got = ordinary ? ::pread(descriptor, head.data(), head.size(), 0) : -1;
  ::close(descriptor);
  if (got <= 0) return {};
  std::int32_t channel_size = 0;
  const auto event = event_at(0, head.data(), static_cast<std::size_t>(got), status.st_size, channel_size);
  if (!event) return {};
  return {reinterpret_cast<const char*>(head.data()) + kHeader, static_cast<std::size_t>(channel_size)};
}

bool looks_like_event_log(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  std::array<std::uint8_t, 4> head{};
  const bool read = ::pread(descriptor, head.data(), head.size(), 0) == 4;
  ::close(descriptor);
  return read && ByteReader(head.data(), head.size()).number<std::uint32_t>() == kMagic;
}

}  // namespace cliquevo::drivers
