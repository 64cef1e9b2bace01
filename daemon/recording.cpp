// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/recording.h"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <filesystem>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "daemon/clock.h"

namespace cliquevo::daemon {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPrefix = "cliquevo-";
constexpr std::int64_t kMegabyte = 1'000'000;

// The logs of earlier recordings, oldest first: their names begin with their time.
std::vector<std::string> earlier_logs(const std::string& folder) {
  std::vector<std::string> logs;
  std::error_code ec;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    const fs::path& file = entry->path();
    if (file.extension() == ".lcm" && file.filename().string().starts_with(kPrefix)) logs.push_back(file.string());
  }
  std::sort(logs.begin(), logs.end());
  return logs;
}

}  // namespace

struct Recording::Impl {
  RecordingConfig config;
  const drivers::SourceInfo* info = nullptr;
  bool lossless = false;
  std::atomic<std::int64_t> log_time_us{0};  // of the last pair: messages go beside it
  std::atomic<bool> active{false};
  std::mutex mutex;
  std::shared_ptr<drivers::Recorder> recorder;  // whoever adds keeps it alive meanwhile
  bool told = false;
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

Result<void> Recording::start() {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  const RecordingConfig& config = impl_->config;
  if (impl_->recorder) return {};
  if (config.folder.empty())
    return Error{"cannot record", "recording.folder is empty", "name a folder in the configuration"};
  std::error_code ec;
  fs::create_directories(config.folder, ec);
  if (ec) return Error{"cannot record", config.folder, ec.message() + ": name a folder that can be written"};
  drivers::RecorderOptions options;
  options.path = fmt::format("{}/{}{:%Y%m%dT%H%M%SZ}.lcm", config.folder, kPrefix,
                             fmt::gmtime(static_cast<std::time_t>(utc_now_ns() / 1'000'000'000)));
  options.max_file_bytes = std::max<std::int64_t>(1, std::min(config.max_file_mb, config.max_total_mb / 2)) * kMegabyte;
  options.max_total_bytes = config.max_total_mb * kMegabyte;
  options.max_queue_bytes = config.queue_mb * kMegabyte;
  options.wait_when_full = impl_->lossless;
  options.older_files = earlier_logs(config.folder);
  auto recorder = drivers::Recorder::start(options, *impl_->info);
  if (!recorder) return recorder.error();
  impl_->recorder = std::make_shared<drivers::Recorder>(std::move(*recorder));
  impl_->told = false;
  impl_->active.store(true, std::memory_order_release);
  spdlog::info("recording into {}", options.path);
  return {};
}

Result<void> Recording::stop() {
  std::shared_ptr<drivers::Recorder> recorder;
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    recorder = std::move(impl_->recorder);
    impl_->active.store(false, std::memory_order_release);
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
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (!impl_->recorder) return "";
  if (const auto failure = impl_->recorder->failure()) {
    if (!impl_->told) spdlog::error(failure->line());
    impl_->told = true;
    return "recording failed";
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
