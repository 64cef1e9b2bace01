// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/log.h"

#include <atomic>
#include <cstdlib>
#include <memory>
#include <sys/uio.h>
#include <syslog.h>
#include <systemd/sd-journal.h>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/systemd_sink.h>
#include <spdlog/spdlog.h>

#include "core/base/printable.h"
#include "core/base/standard_streams.h"

namespace cliquevo::daemon {

namespace {

std::atomic<bool> is_set_up{false};

// systemd sets it for a service whose stderr is the journal.
bool in_journal() { return std::getenv("JOURNAL_STREAM") != nullptr; }

// What names of files and cameras hold is made printable: one call, one line.
class PlainLogger final : public spdlog::logger {
 public:
  using spdlog::logger::logger;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text = printable({message.payload.data(), message.payload.size()});
    spdlog::details::log_msg plain = message;
    plain.payload = text;
    spdlog::logger::sink_it_(plain);
  }
};

std::shared_ptr<spdlog::logger> make_logger() {
  std::shared_ptr<spdlog::sinks::sink> sink;
  if (in_journal()) {
    sink = std::make_shared<spdlog::sinks::systemd_sink_mt>("cliquevod");
  } else {
    sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
    sink->set_pattern("%H:%M:%S.%e %^%l%$ %v");
  }
  auto logger = std::make_shared<PlainLogger>("cliquevod", std::move(sink));
  // A stderr that takes nothing is no reason to write to it.
  logger->set_error_handler([](const std::string&) {});
  return logger;
}

// What spdlog's own sink sends, and the fields.
void send_to_journal(int priority, const std::string& line, const LogFields& fields) {
  std::vector<std::string> parts{"MESSAGE=" + printable(line), "PRIORITY=" + std::to_string(priority),
                                 "SYSLOG_IDENTIFIER=cliquevod"};
  for (const auto& [name, value] : fields) parts.push_back("CLIQUEVO_" + name + "=" + printable(value));
  std::vector<iovec> pieces;
  pieces.reserve(parts.size());
  for (std::string& part : parts) pieces.push_back({part.data(), part.size()});
  static_cast<void>(sd_journal_sendv(pieces.data(), static_cast<int>(pieces.size())));
}

}  // namespace

void set_up_log(const std::string& level) {
  // Once: other threads use the logger while its level changes.
  static const bool made = (spdlog::set_default_logger(make_logger()), true);
  is_set_up = made;
  spdlog::default_logger_raw()->set_level(spdlog::level::from_str(level));
}

void report(const Error& error) {
  // The journal may not know any more whose message it is when the program has ended: what ends its start goes to
  // stderr, which the journal follows.
  if (in_journal() && is_set_up) {
    send_to_journal(LOG_ERR, error.line(), {{"WHAT", error.what}, {"WHERE", error.where}, {"REMEDY", error.remedy}});
  } else {
    print_error_line(error.line());
  }
}

void log_fields(const std::string& line, const LogFields& fields) {
  if (in_journal()) send_to_journal(LOG_INFO, line, fields);
}

}  // namespace cliquevo::daemon
