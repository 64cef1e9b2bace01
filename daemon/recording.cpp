// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/recording.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/caught.h"
#include "core/base/clock.h"
#include "core/base/printable.h"
#include "daemon/log_names.h"

namespace cliquevo::daemon {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kMegabyte = 1'000'000;

}  // namespace

struct Recording::Impl {
  RecordingConfig config;
  const drivers::SourceInfo* info = nullptr;
  bool lossless = false;
  std::atomic<std::int64_t> log_time_us{0};  // of the last pair: messages go beside it
  std::atomic<bool> active{false};
  std::mutex mutex;
  std::shared_ptr<drivers::Recorder> recorder;  // whoever adds keeps it alive meanwhile
  bool reported = false;
  std::optional<Error> refused;  // why the last start() was none

  Result<void> start();
  Result<drivers::Recorder> open_recorder(drivers::RecorderOptions options);
};

Recording::Recording(const RecordingConfig& config, const drivers::SourceInfo& info, bool lossless)
    : impl_(std::make_unique<Impl>()) {
  impl_->config = config;
  impl_->info = &info;
  impl_->lossless = lossless;
}
Recording::~Recording() { static_cast<void>(stop()); }

bool Recording::active() const { return impl_->active.load(std::memory_order_acquire); }

void Recording::configure(const RecordingConfig& config) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  impl_->config = config;
}

// The first name that is free. Another daemon, or a clock that began at the same time before, may have taken it.
Result<drivers::Recorder> Recording::Impl::open_recorder(drivers::RecorderOptions options) {
  constexpr int kTries = 100;
  const std::int64_t now_s = utc_now_ns() / 1'000'000'000;
  options.older_files = own_logs(config.folder);
  for (int run = next_run(config.folder, now_s), last = run + kTries;; ++run) {
    options.path = config.folder + "/" + log_name(now_s, run);
    auto started = drivers::Recorder::start(options, *info);
    std::error_code ec;
    if (started || run == last || !fs::exists(drivers::first_file_of(options), ec)) {
      if (started) spdlog::info("recording into {}", options.path);
      return started;
    }
  }
}

Result<void> Recording::Impl::start() {
  if (config.folder.empty())
    return Error{"cannot record", "recording.folder is empty", "name a folder in the configuration"};
  std::error_code ec;
  fs::create_directories(config.folder, ec);
  if (ec) return Error{"cannot record", config.folder, ec.message() + ": name a folder that can be written"};
  drivers::RecorderOptions options;
  options.max_file_bytes = std::max<std::int64_t>(1, std::min(config.max_file_mb, config.max_total_mb / 2)) * kMegabyte;
  options.max_total_bytes = config.max_total_mb * kMegabyte;
  options.max_queue_bytes = config.queue_mb * kMegabyte;
  options.wait_when_full = lossless;
  auto opened = open_recorder(std::move(options));
  if (!opened) return opened.error();
  recorder = std::make_shared<drivers::Recorder>(std::move(*opened));
  return {};
}

Result<void> Recording::start() {
  std::shared_ptr<drivers::Recorder> failed;  // its thread is waited for without the lock
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    if (impl_->recorder && !impl_->recorder->failure()) return {};
    failed = std::move(impl_->recorder);
    impl_->active.store(false, std::memory_order_release);
  }
  if (failed) static_cast<void>(failed->stop());
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (impl_->recorder) return {};
  auto started = guarded("recording", [&] { return impl_->start(); });
  impl_->reported = false;
  impl_->refused.reset();
  if (!started) impl_->refused = started.error();
  impl_->active.store(started.ok(), std::memory_order_release);
  return started;
}

Result<void> Recording::stop() {
  std::shared_ptr<drivers::Recorder> recorder;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    recorder = std::move(impl_->recorder);
    impl_->active.store(false, std::memory_order_release);
    impl_->refused.reset();
  }
  if (!recorder) return {};
  Result<void> done = recorder->stop();
  const drivers::RecorderCounts counts = recorder->counts();
  spdlog::info("recording ended: {} pairs and {} messages in {} files, {} left out", counts.pairs, counts.messages,
               counts.files, counts.left_out);
  return done;
}

void Recording::add(const drivers::StereoPair& pair) {
  if (!active()) return;
  std::shared_ptr<drivers::Recorder> recorder;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    recorder = impl_->recorder;
  }
  if (!recorder) return;
  const std::int64_t utime = drivers::log_utime(*impl_->info, pair);
  impl_->log_time_us.store(utime, std::memory_order_relaxed);
  recorder->add(pair, utime);
}

void Recording::add(const std::string& channel, const std::uint8_t* data, std::size_t size) {
  if (!active()) return;
  std::shared_ptr<drivers::Recorder> recorder;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    recorder = impl_->recorder;
  }
  if (!recorder) return;
  const std::int64_t utime =
      impl_->info->live ? utc_now_ns() / 1000 : impl_->log_time_us.load(std::memory_order_relaxed);
  recorder->add(channel, data, size, utime);
}

std::string Recording::status() {
  const std::unique_lock<std::mutex> lock(impl_->mutex, std::try_to_lock);
  if (!lock.owns_lock()) return "recording, the disk is waited for";  // the watchdog's feeder waits for no disk
  if (impl_->refused) return printable("recording failed: " + impl_->refused->line());
  if (!impl_->recorder) return "";
  if (const auto failure = impl_->recorder->failure()) {
    if (!std::exchange(impl_->reported, true)) spdlog::error(failure->line());
    return printable("recording failed: " + failure->line());
  }
  const drivers::RecorderCounts counts = impl_->recorder->counts();
  return fmt::format("recording, {} pairs, {} left out", counts.pairs, counts.left_out);
}

namespace {

class Recorded final : public drivers::FrameSource {
 public:
  Recorded(std::unique_ptr<drivers::FrameSource> source, Recording& recording)
      : source_(std::move(source)), recording_(recording) {}

  const drivers::SourceInfo& info() const override { return source_->info(); }
  Result<bool> next(drivers::StereoPair& pair) override {
    auto more = source_->next(pair);
    if (more.ok() && *more) recording_.add(pair);
    return more;
  }
  void interrupt() override { source_->interrupt(); }
  std::string status() const override { return source_->status(); }
  std::string finding() const override { return source_->finding(); }
  std::string queues() const override { return source_->queues(); }

 private:
  std::unique_ptr<drivers::FrameSource> source_;
  Recording& recording_;
};

}  // namespace

std::unique_ptr<drivers::FrameSource> record_pairs(std::unique_ptr<drivers::FrameSource> source, Recording& recording) {
  return std::make_unique<Recorded>(std::move(source), recording);
}

}  // namespace cliquevo::daemon
