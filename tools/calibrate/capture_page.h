// SPDX-License-Identifier: BSD-3-Clause
// The page that guides: serves what is looked at and what the guide says, takes the buttons.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/result.h"
#include "drivers/frame_source.h"
#include "tools/calibrate/guide.h"
#include "tools/view/pictures.h"
#include "tools/view/server.h"

namespace cliquevo::tools {

class CapturePage {
 public:
  // Serves on a thread of its own until it is destroyed.
  static Result<std::unique_ptr<CapturePage>> open(const view::ServerOptions& options, const std::string& source,
                                                   const std::string& version);
  ~CapturePage();
  CapturePage(const CapturePage&) = delete;
  CapturePage& operator=(const CapturePage&) = delete;

  std::string address() const;
  // One thread calls all that follows.
  void show(const drivers::StereoPair& pair, const Look& look, Refusal refusal, const Guide& guide);
  // looking, solving, done, failed; what there is to say about it.
  void set_phase(const std::string& phase, const std::string& text);
  // Whether a button was pressed since the last call.
  bool take_wanted() { return take_.exchange(false); }
  bool drop_wanted() { return drop_.exchange(false); }
  bool finish_wanted() { return finish_.exchange(false); }
  // Waits until a page that is open has the last state.
  void linger() const;

 private:
  CapturePage() = default;
  std::string state() const;

  std::unique_ptr<view::Store> store_;
  view::Ros2Topics topics_;  // none: viewers see nothing here
  std::unique_ptr<view::Server> server_;
  view::JpegEncoder jpeg_;
  mutable std::mutex mutex_;
  std::string looked_;  // JSON members without braces
  std::string phase_ = "looking";
  std::string text_;
  std::atomic<bool> take_{false}, drop_{false}, finish_{false}, ending_{false}, greeted_{false};
  mutable std::atomic<bool> last_sent_{false};
  std::thread thread_;
};

}  // namespace cliquevo::tools
