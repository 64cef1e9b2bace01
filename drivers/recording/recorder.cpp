// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recorder.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "core/base/caught.h"
#include "core/base/clock.h"
#include "drivers/recording/calibration_message.h"
#include "drivers/recording/event_log.h"
#include "drivers/recording/stereo_message.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

std::string file_of(const RecorderOptions& options, int number) {
  if (options.max_file_bytes <= 0) return options.path;
  const fs::path whole(options.path);
  const std::string name = fmt::format("{}-{:03d}{}", whole.stem().string(), number, whole.extension().string());
  return (whole.parent_path() / name).string();
}

}  // namespace

struct Recorder::Impl {
  struct Event {
    std::string channel;
    std::vector<std::uint8_t> data;
    std::int64_t utime = 0;
    bool is_pair = false;
  };

  Impl(const RecorderOptions& o, std::vector<std::uint8_t> calibration_)
      : options(o), calibration(std::move(calibration_)) {
    for (const std::string& file : options.older_files) {
      std::error_code ec;
      const auto size = fs::file_size(file, ec);
      if (!ec) kept.push_back({file, static_cast<std::int64_t>(size)});
    }
  }

  Result<void> open_next();
  Result<void> write(const Event& event);
  void make_room();
  void run();
  template <typename Fill>
  bool queue(std::size_t bytes, bool is_pair, bool may_wait, std::int64_t utime, const Fill& fill);

  struct File {
    std::string path;
    std::int64_t bytes = 0;
  };
  RecorderOptions options;
  std::vector<std::uint8_t> calibration;
  std::optional<EventLogWriter> writer;  // the thread's
  std::deque<File> kept;                 // closed ones, oldest first; the thread's
  int number = 0;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<Event> waiting;
  std::vector<std::vector<std::uint8_t>> spare;  // memory that was used before
  std::int64_t waiting_bytes = 0;
  RecorderCounts counts;
  std::optional<Error> failure;
  bool stopping = false;
  std::thread thread;
};

Result<void> Recorder::Impl::open_next() {
  if (writer) {
    kept.push_back({writer->path(), writer->bytes()});
    writer.reset();
  }
  auto opened = EventLogWriter::create(file_of(options, number++));
  if (!opened) return opened.error();
  writer.emplace(std::move(*opened));
  const std::lock_guard<std::mutex> lock(mutex);
  ++counts.files;
  return {};
}

// Keeps the whole below the cap, with room for what the present file may grow to.
void Recorder::Impl::make_room() {
  if (options.max_total_bytes <= 0) return;
  std::int64_t total = std::max(writer->bytes(), options.max_file_bytes);
  for (const File& file : kept) total += file.bytes;
  while (total > options.max_total_bytes && !kept.empty()) {
    std::error_code ignored;
    // Looked at again: somebody may have put another file in its place.
    if (is_own_log(kept.front().path)) fs::remove(kept.front().path, ignored);
    total -= kept.front().bytes;
    kept.pop_front();
  }
}

Result<void> Recorder::Impl::write(const Event& event) {
  const bool full = options.max_file_bytes > 0 && writer->bytes() > 0 &&
                    writer->bytes() + static_cast<std::int64_t>(event.data.size()) > options.max_file_bytes;
  const bool fresh = writer->bytes() == 0;
  if (full) {
    if (auto ok = open_next(); !ok) return ok;
  }
  if (full || fresh) {
    make_room();
    if (auto ok = writer->write(kCalibrationChannel, calibration.data(), calibration.size(), event.utime); !ok)
      return ok;
  }
  return writer->write(event.channel, event.data.data(), event.data.size(), event.utime);
}

void Recorder::Impl::run() {
  std::unique_lock<std::mutex> lock(mutex);
  for (;;) {
    changed.wait(lock, [this] { return stopping || !waiting.empty(); });
    if (waiting.empty()) return;
    Event event = std::move(waiting.front());
    waiting.pop_front();
    const bool go_on = !failure;
    lock.unlock();
    const Result<void> done = go_on ? guarded("recording", [&] { return write(event); }) : Result<void>();
    lock.lock();
    waiting_bytes -= static_cast<std::int64_t>(event.data.size());
    if (!done.ok()) failure = done.error();
    if (failure) {
      ++counts.left_out;
    } else {
      ++(event.is_pair ? counts.pairs : counts.messages);
      counts.bytes += static_cast<std::int64_t>(event.data.size());
    }
    if (event.is_pair) spare.push_back(std::move(event.data));
    changed.notify_all();
  }
}

// Pairs may fill the queue; messages are small and go beyond, but not without end.
template <typename Fill>
bool Recorder::Impl::queue(std::size_t bytes, bool is_pair, bool may_wait, std::int64_t utime, const Fill& fill) {
  const std::int64_t most = options.max_queue_bytes + (is_pair ? 0 : std::int64_t{4} << 20);
  Event event;
  {
    std::unique_lock<std::mutex> lock(mutex);
    const auto fits = [&] { return waiting.empty() || waiting_bytes + static_cast<std::int64_t>(bytes) <= most; };
    if (may_wait) changed.wait(lock, [&] { return fits() || failure || stopping; });
    if (failure || stopping || !fits()) {
      ++counts.left_out;
      return false;
    }
    if (is_pair && !spare.empty()) {
      event.data = std::move(spare.back());
      spare.pop_back();
    }
  }
  event.is_pair = is_pair;
  event.utime = utime;
  fill(event);
  {
    const std::lock_guard<std::mutex> lock(mutex);
    waiting_bytes += static_cast<std::int64_t>(event.data.size());
    waiting.push_back(std::move(event));
  }
  changed.notify_all();
  return true;
}

Result<Recorder> Recorder::start(const RecorderOptions& options, const SourceInfo& info) {
  auto impl = std::make_unique<Impl>(options, encode_calibration(info, utc_now_ns()));
  if (auto ok = impl->open_next(); !ok) return ok.error();
  const auto started = guarded("recording", [&] {
    impl->thread = std::thread([self = impl.get()] { self->run(); });
    return Result<void>();
  });
  if (!started) return started.error();
  return Recorder(std::move(impl));
}

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recorder::Recorder(Recorder&&) noexcept = default;
Recorder& Recorder::operator=(Recorder&& other) noexcept {
  if (impl_) static_cast<void>(stop());
  impl_ = std::move(other.impl_);
  return *this;
}
Recorder::~Recorder() {
  if (impl_) static_cast<void>(stop());
}

bool Recorder::add(const StereoPair& pair, std::int64_t utime) {
  const std::size_t pixels =
      static_cast<std::size_t>(pair.left.width()) * static_cast<std::size_t>(pair.left.height()) +
      static_cast<std::size_t>(pair.right.width()) * static_cast<std::size_t>(pair.right.height());
  return impl_->queue(pixels, true, impl_->options.wait_when_full, utime, [&pair](Impl::Event& event) {
    event.channel = kStereoChannel;
    encode_stereo(pair, event.data);
  });
}

bool Recorder::add(const std::string& channel, const std::uint8_t* data, std::size_t size, std::int64_t utime) {
  return impl_->queue(size, false, false, utime, [&](Impl::Event& event) {
    event.channel = channel;
    event.data.assign(data, data + size);
  });
}

RecorderCounts Recorder::counts() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->counts;
}

std::optional<Error> Recorder::failure() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->failure;
}

Result<void> Recorder::stop() {
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->stopping = true;
  }
  impl_->changed.notify_all();
  if (impl_->thread.joinable()) impl_->thread.join();
  // A log without pairs still holds the calibration.
  if (impl_->writer && impl_->writer->bytes() == 0 && !impl_->failure) {
    const std::int64_t now_us = utc_now_ns() / 1000;
    const auto& calibration = impl_->calibration;
    if (auto ok = impl_->writer->write(kCalibrationChannel, calibration.data(), calibration.size(), now_us); !ok) {
      impl_->failure = ok.error();
    }
  }
  impl_->writer.reset();
  if (impl_->failure) return *impl_->failure;
  return {};
}

std::string first_file_of(const RecorderOptions& options) { return file_of(options, 0); }

bool is_own_log(const std::string& path) { return first_channel(path) == kCalibrationChannel; }

std::int64_t log_utime(const SourceInfo& info, const StereoPair& pair) {
  if (!info.live) return pair.stamp_ns / 1000;
  return (pair.host_ns != 0 ? pair.host_ns : utc_now_ns()) / 1000;
}

}  // namespace cliquevo::drivers
