// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/control/incidents.h"

#include <algorithm>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/time.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::size_t kMostKinds = 16;
constexpr std::int64_t kRecentNs = 60 * kSecondNs;

}  // namespace

void Incidents::note(const std::string& what, bool fault) {
  const std::int64_t now_ns = monotonic_ns();
  std::int64_t since_logged = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (kinds_.size() >= kMostKinds && !kinds_.contains(what)) {
      kinds_.erase(std::min_element(kinds_.begin(), kinds_.end(),
                                    [](const auto& a, const auto& b) { return a.second.last_ns < b.second.last_ns; }));
    }
    Kind& kind = kinds_[what];
    kind.fault = fault;
    ++kind.count;
    kind.last_ns = now_ns;
    if (kind.logged_count == 0 || now_ns - kind.logged_ns >= kSecondNs) {
      since_logged = kind.count - kind.logged_count;
      kind.logged_ns = now_ns;
      kind.logged_count = kind.count;
    }
  }
  const auto level = fault ? spdlog::level::warn : spdlog::level::info;
  if (since_logged == 1) spdlog::log(level, what);
  if (since_logged > 1) spdlog::log(level, "{} ({} times)", what, since_logged);
}

std::string Incidents::text() const {
  const std::int64_t now_ns = monotonic_ns();
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string out;
  for (const auto& [what, kind] : kinds_) {
    if (!kind.fault || now_ns - kind.last_ns > kRecentNs) continue;
    out += fmt::format("{}{} ({} times since the start)", out.empty() ? "" : "; ", what, kind.count);
  }
  return out;
}

}  // namespace cliquevo::daemon
