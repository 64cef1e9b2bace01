// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/first_pairs.h"

#include <array>
#include <exception>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/calibration/examine.h"

namespace cliquevo::daemon {

namespace {

using drivers::SourceInfo;
using drivers::StereoPair;

class FirstPairs final : public drivers::FrameSource {
 public:
  FirstPairs(std::unique_ptr<FrameSource> source, std::function<void(const std::string&)> report)
      : source_(std::move(source)), report_(std::move(report)) {}
  ~FirstPairs() override {
    if (thread_.joinable()) thread_.join();
  }
  FirstPairs(const FirstPairs&) = delete;
  FirstPairs& operator=(const FirstPairs&) = delete;

  const SourceInfo& info() const override { return source_->info(); }
  Result<bool> next(StereoPair& pair) override {
    Result<bool> result = source_->next(pair);
    if (result && *result && taken_ < pairs_.size()) take(pair);
    return result;
  }
  void interrupt() override { source_->interrupt(); }
  std::string status() const override { return source_->status(); }
  std::string finding() const override { return source_->finding(); }
  std::string queues() const override { return source_->queues(); }

 private:
  struct Images {
    Image<std::uint8_t> left;
    Image<std::uint8_t> right;
  };

  // Cameras still settle their exposure with the first frames: every tenth is taken.
  void take(const StereoPair& pair) {
    if (++seen_ % 10 != 0) return;
    Images& copy = pairs_[taken_++];
    copy.left.copy_from(pair.left.cview());
    copy.right.copy_from(pair.right.cview());
    if (taken_ == pairs_.size()) thread_ = std::thread([this] { examine(); });
  }
  void examine() {
    try {
      std::vector<drivers::ImagePairView> views;
      for (const Images& pair : pairs_) views.push_back({pair.left.cview(), pair.right.cview()});
      const std::string line = drivers::contradiction(source_->info().calibration, views);
      if (!line.empty()) report_(line);
    } catch (const std::exception&) {  // no memory: what is not looked at is not reported
    }
  }

  std::unique_ptr<FrameSource> source_;
  std::function<void(const std::string&)> report_;
  std::array<Images, 3> pairs_;
  std::size_t taken_ = 0;
  int seen_ = 0;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<drivers::FrameSource> examine_first_pairs(std::unique_ptr<drivers::FrameSource> source,
                                                          std::function<void(const std::string&)> report) {
  if (!source->info().live) return source;
  return std::make_unique<FirstPairs>(std::move(source), std::move(report));
}

}  // namespace cliquevo::daemon
