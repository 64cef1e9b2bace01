// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/view.h"

#include <atomic>
#include <csignal>
#include <mutex>
#include <spawn.h>
#include <thread>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/base/caught.h"
#include "daemon/control/control_client.h"
#include "tools/view/base64.h"
#include "tools/view/check_words.h"
#include "tools/view/metrics.h"

extern char** environ;

namespace cliquevo::view {

namespace {

using nlohmann::json;

constexpr std::size_t kMostRecords = 120'000;     // an hour at 30 Hz, some 80 MB
constexpr std::size_t kMostLiveRecords = 18'000;  // ten minutes

// Has the daemon record, on a thread of its own: it may take a while to answer.
class RecordSwitch {
 public:
  explicit RecordSwitch(std::string socket) : socket_(std::move(socket)) {}
  ~RecordSwitch() {
    if (thread_.joinable()) thread_.join();
  }
  bool allowed() const { return !socket_.empty() && ::access(socket_.c_str(), W_OK) == 0; }
  void turn(bool on) {
    if (!allowed() || busy_.exchange(true)) return;
    if (thread_.joinable()) thread_.join();
    thread_ = std::thread([this, on] {
      const auto reply = daemon::ask_daemon(socket_, on ? "record-start" : "record-stop");
      const std::lock_guard lock(mutex_);
      answer_ = reply ? *reply : reply.error().line();
      busy_ = false;
    });
  }
  std::string answer() const {
    const std::lock_guard lock(mutex_);
    return answer_;
  }

 private:
  const std::string socket_;
  std::thread thread_;
  std::atomic<bool> busy_{false};
  mutable std::mutex mutex_;
  std::string answer_;
};

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

json model_json(const std::optional<StereoModel>& m) {
  if (!m) return nullptr;
  return {{"width", m->width}, {"height", m->height},       {"fx", m->fx_px},      {"fy", m->fy_px}, {"cx", m->cx_px},
          {"cy", m->cy_px},    {"baseline", m->baseline_m}, {"doffs", m->doffs_px}};
}

std::string hello(const Feed& feed, const ViewOptions& options) {
  json out = check_words();
  out.update({{"op", "hello"}, {"source", feed.source()}, {"live", feed.live()}, {"version", options.version}});
  return text_of(out);
}

// The message of the mask, made anew when there is another one.
class MaskMessage {
 public:
  std::shared_ptr<const std::string> message(const Feed& feed) {
    auto mask = feed.state().mask;
    if (mask == of_ || !mask) return message_;
    of_ = std::move(mask);
    message_ = std::make_shared<const std::string>(
        text_of({{"op", "mask"}, {"image", "data:image/jpeg;base64," + base64(*of_)}}));
    return message_;
  }

 private:
  std::shared_ptr<const Bytes> of_;
  std::shared_ptr<const std::string> message_;
};

std::string state(const Feed& feed, const Store& store, const RecordSwitch& recording) {
  const FeedState s = feed.state();
  json out = {{"op", "state"},
              {"text", s.text},
              {"error", s.error},
              {"done", s.done},
              {"frames", s.frames},
              {"model", model_json(s.model)},
              {"check", s.check_text},
              {"view", s.view_text},
              {"level", s.level},
              {"lost_pictures", store.extent().lost_pictures},
              {"may_record", recording.allowed()},
              {"answer", recording.answer()}};
  if (!s.health_json.empty()) out["health"] = json::parse(s.health_json, nullptr, false);
  return text_of(out);
}

void open_browser(const std::string& address) {
  std::string program = "xdg-open";
  std::string argument = address;
  char* const arguments[] = {program.data(), argument.data(), nullptr};
  pid_t child = -1;
  std::signal(SIGCHLD, SIG_IGN);  // nobody waits for it
  static_cast<void>(posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments, environ));
}

}  // namespace

Result<void> run_view(std::unique_ptr<Feed> feed, const ViewOptions& options,
                      const std::function<void(const std::string& address)>& announce,
                      const std::function<bool()>& stopped) {
  auto store = Store::make(options.keep_mb << 20, feed->live() ? kMostLiveRecords : kMostRecords);
  if (!store) return store.error();
  Ros2Topics topics;
  RecordSwitch recording(options.control_socket);
  PageContent content;
  content.hello = [&] { return hello(*feed, options); };
  content.state = [&] { return state(*feed, **store, recording); };
  MaskMessage mask;
  content.mask = [&] { return mask.message(*feed); };
  content.metrics = [&] { return metrics_text(feed->state(), options.version); };
  content.command = [&](PageCommand::What what) {
    const bool start = what == PageCommand::What::record_start;
    if (start || what == PageCommand::What::record_stop) recording.turn(start);
  };
  ServerOptions serving = options.server;
  serving.version = options.version;
  auto server = Server::open(serving, **store, topics, std::move(content));
  if (!server) return server.error();
  std::atomic<bool> ending{false};
  std::atomic<bool> ended{false};
  Result<void> outcome;
  std::thread feeding([&] {
    outcome = guarded("view", [&]() -> Result<void> {
      feed->run(**store, topics, [&ending] { return ending.load(); });
      return {};
    });
    ended = true;
  });
  announce((*server)->address());
  if (options.open_browser) open_browser((*server)->address());
  (*server)->run([&] { return stopped() || (ended.load() && !outcome); });
  ending = true;
  feeding.join();
  return outcome;
}

}  // namespace cliquevo::view
