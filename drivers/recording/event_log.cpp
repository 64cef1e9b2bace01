// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/event_log.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <lcm/eventlog.h>

#include "drivers/recording/bytes.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

// An event is: this number, its own number (8 bytes), its time (8), lengths of channel and data (4 each), channel,
// data.
constexpr std::uint32_t kMagic = 0xEDA1DA01;
constexpr std::int64_t kHeader = 28;
constexpr std::int32_t kLongestChannel = 255;
constexpr std::int64_t kSearchStep = 1 << 16;

}  // namespace

struct EventLogWriter::Impl {
  ~Impl() {
    if (log != nullptr) lcm_eventlog_destroy(log);
  }
  // What stdio still holds may reach the file while it is closed: cut off afterwards.
  void close_behind_last_event() {
    lcm_eventlog_destroy(log);
    log = nullptr;
    std::error_code ignored;
    fs::resize_file(path, static_cast<std::uintmax_t>(bytes), ignored);
  }
  lcm_eventlog_t* log = nullptr;
  std::string path;
  std::int64_t bytes = 0;
};

EventLogWriter::EventLogWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EventLogWriter::EventLogWriter(EventLogWriter&&) noexcept = default;
EventLogWriter& EventLogWriter::operator=(EventLogWriter&&) noexcept = default;
EventLogWriter::~EventLogWriter() = default;
std::int64_t EventLogWriter::bytes() const { return impl_->bytes; }
const std::string& EventLogWriter::path() const { return impl_->path; }

Result<EventLogWriter> EventLogWriter::create(const std::string& path) {
  std::error_code ec;
  if (fs::exists(path, ec)) return Error{"cannot write log", path, "it is there already: name a new file"};
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  errno = 0;
  impl->log = lcm_eventlog_create(path.c_str(), "w");
  if (impl->log == nullptr) {
    return Error{"cannot write log", path, std::string(std::strerror(errno)) + ": name a file in a folder of yours"};
  }
  return EventLogWriter(std::move(impl));
}

Result<void> EventLogWriter::write(const std::string& channel, const std::uint8_t* data, std::size_t size,
                                   std::int64_t utime) {
  Impl& m = *impl_;
  if (m.log == nullptr) return Error{"cannot write log", m.path, "an earlier event did not fit"};
  lcm_eventlog_event_t event{};
  event.timestamp = utime;
  event.channellen = static_cast<std::int32_t>(channel.size());
  event.datalen = static_cast<std::int32_t>(size);
  event.channel = const_cast<char*>(channel.data());
  event.data = const_cast<std::uint8_t*>(data);
  errno = 0;
  // Out with it at once: what is in the program's own memory goes with the program.
  if (lcm_eventlog_write_event(m.log, &event) != 0 || std::fflush(m.log->f) != 0) {
    const std::string why = std::strerror(errno);
    m.close_behind_last_event();
    return Error{"cannot write log", m.path, why + ": it holds everything before; free some space"};
  }
  m.bytes += kHeader + event.channellen + event.datalen;
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
    if (got <= 0) return false;
    to += got;
    at += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

// The next place that begins like an event, at `from` or behind; the file's size when there is none.
std::int64_t EventLogReader::find_event(std::int64_t from) const {
  std::vector<std::uint8_t> window(static_cast<std::size_t>(kSearchStep) + 3);
  for (std::int64_t at = from; at + 4 <= size_; at += kSearchStep) {
    const auto count = static_cast<std::size_t>(std::min<std::int64_t>(size_ - at, kSearchStep + 3));
    if (!read_at(at, window.data(), count)) break;
    for (std::size_t i = 0; i + 4 <= count; ++i) {
      if (window[i] == 0xED && ByteReader(&window[i], 4).number<std::uint32_t>() == kMagic) {
        return at + static_cast<std::int64_t>(i);
      }
    }
  }
  return size_;
}

LogDamage EventLogReader::scan(const std::function<void(std::string_view, const LoggedEvent&)>& on_event) const {
  LogDamage damage;
  std::int64_t whole_until = 0;
  std::array<std::uint8_t, kHeader + kLongestChannel> bytes{};
  for (std::int64_t at = 0; at < size_;) {
    const auto here = static_cast<std::size_t>(std::min<std::int64_t>(size_ - at, bytes.size()));
    if (!read_at(at, bytes.data(), here)) break;
    ByteReader reader(bytes.data(), here);
    const auto magic = reader.number<std::uint32_t>();
    reader.number<std::int64_t>();
    LoggedEvent event;
    event.utime = reader.number<std::int64_t>();
    const auto channel_size = reader.number<std::int32_t>();
    event.size = reader.number<std::int32_t>();
    event.data_at = at + kHeader + channel_size;
    const bool sane = reader.ok() && magic == kMagic && channel_size > 0 && channel_size <= kLongestChannel &&
                      event.size >= 0 && event.data_at + event.size <= size_;
    if (!sane) {
      const std::int64_t next = find_event(at + 1);
      if (next < size_) ++damage.broken_places;
      at = next;
      continue;
    }
    on_event({reinterpret_cast<const char*>(bytes.data()) + kHeader, static_cast<std::size_t>(channel_size)}, event);
    at = event.data_at + event.size;
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

bool looks_like_event_log(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  std::array<std::uint8_t, 4> head{};
  const bool read = ::pread(descriptor, head.data(), head.size(), 0) == 4;
  ::close(descriptor);
  return read && ByteReader(head.data(), head.size()).number<std::uint32_t>() == kMagic;
}

}  // namespace cliquevo::drivers
