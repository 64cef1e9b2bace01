// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/command_receiver.h"

#include <atomic>
#include <utility>

#include <lcm/lcm-cpp.hpp>

#include "core/rt/thread.h"

namespace cliquevo::daemon {

namespace {

constexpr int kPollMs = 100;  // how soon it notices that it should end

}  // namespace

struct CommandReceiver::Impl {
  Impl(const std::string& url, std::string channel_, std::function<void(const command_t&)> on_command_)
      : lcm(url), channel(std::move(channel_)), on_command(std::move(on_command_)) {}
  ~Impl() { stop = true; }

  void listen() {
    // Here, not at start: where multicast does not come back, LCM spends ten seconds finding out.
    lcm.subscribe(channel, &Impl::handle, this);
    while (!stop) lcm.handleTimeout(kPollMs);
  }
  void handle(const lcm::ReceiveBuffer*, const std::string&, const command_t* command) { on_command(*command); }

  lcm::LCM lcm;
  std::string channel;
  std::function<void(const command_t&)> on_command;
  std::atomic<bool> stop{false};
  rt::Thread thread;  // last: joined first
};

Result<CommandReceiver> CommandReceiver::start(const std::string& url, const std::string& channel,
                                               std::function<void(const command_t&)> on_command) {
  const bool write_only = url.rfind("file:", 0) == 0;
  if (write_only) return CommandReceiver(nullptr);
  auto impl = std::make_unique<Impl>(url, channel, std::move(on_command));
  if (!impl->lcm.good()) return Error{"LCM does not start", url, "check the URL and the multicast route"};
  auto thread = rt::Thread::start({.name = "vo-command"}, [self = impl.get()] { self->listen(); });
  if (!thread) return thread.error();
  impl->thread = std::move(*thread);
  return CommandReceiver(std::move(impl));
}

CommandReceiver::CommandReceiver(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CommandReceiver::CommandReceiver(CommandReceiver&&) noexcept = default;
CommandReceiver::~CommandReceiver() = default;

}  // namespace cliquevo::daemon
