// SPDX-License-Identifier: BSD-3-Clause
// Repeated errors that do not end the daemon: counted, reported in VO_HEALTH, logged once a second at most.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace cliquevo::daemon {

class Incidents {
 public:
  // Any thread. what: a sentence without a number; of more than 16 different ones the oldest are forgotten.
  void add(const std::string& what) { note(what, true); }
  // The same for what is no error: logged, not in VO_HEALTH.
  void log(const std::string& what) { note(what, false); }
  // Those of the last minute, each with its count since the start; empty = none.
  std::string text() const;

 private:
  struct Kind {
    bool fault = false;
    std::int64_t count = 0;
    std::int64_t last_ns = 0;
    std::int64_t logged_ns = 0;
    std::int64_t logged_count = 0;
  };
  void note(const std::string& what, bool fault);

  mutable std::mutex mutex_;
  std::map<std::string, Kind> kinds_;
};

}  // namespace cliquevo::daemon
