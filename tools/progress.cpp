// SPDX-License-Identifier: BSD-3-Clause
#include "tools/progress.h"

#include <algorithm>
#include <cstdio>
#include <unistd.h>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "core/base/time.h"

namespace cliquevo::tools {

namespace {

constexpr std::int64_t kBarPeriodNs = 100'000'000;
constexpr std::int64_t kLinePeriodNs = 10'000'000'000;

}  // namespace

std::string progress_line(std::int64_t done, std::int64_t total, double rate_hz, double distance_m,
                          const std::string& status, bool bar) {
  std::string out;
  if (bar && total > 0) {
    constexpr std::int64_t kWidth = 30;
    const auto filled = static_cast<std::size_t>(std::clamp<std::int64_t>(done * kWidth / total, 0, kWidth));
    std::string cells(kWidth, ' ');
    std::fill_n(cells.begin(), filled, '=');
    if (filled < kWidth) cells[filled] = '>';
    out = "[" + cells + "] ";
  }
  out += total > 0 ? fmt::format("{}/{}", done, total) : fmt::format("{}", done);
  return out + fmt::format("  {:.1f} Hz  {:.1f} m  {}", rate_hz, distance_m, status);
}

Progress::Progress(std::int64_t total)
    : total_(total), terminal_(::isatty(STDERR_FILENO) == 1), begin_ns_(monotonic_ns()), last_ns_(begin_ns_) {}

Progress::~Progress() { finish(); }

void Progress::update(std::int64_t done, double distance_m, const std::string& status) {
  const std::int64_t now_ns = monotonic_ns();
  const bool due = now_ns - last_ns_ >= (terminal_ ? kBarPeriodNs : kLinePeriodNs) || (terminal_ && done == total_);
  if (!due) return;
  last_ns_ = now_ns;
  const double elapsed_s = static_cast<double>(now_ns - begin_ns_) * 1e-9;
  const double rate_hz = elapsed_s > 0.0 ? static_cast<double>(done) / elapsed_s : 0.0;
  const std::string line = progress_line(done, total_, rate_hz, distance_m, printable(status), terminal_);
  if (terminal_) {
    std::fputs(fmt::format("\r{}\033[K", line).c_str(), stderr);  // a stderr that takes nothing is no reason to end
    drawn_ = true;
  } else {
    std::fputs((line + "\n").c_str(), stderr);
  }
  std::fflush(stderr);
}

void Progress::finish() {
  if (drawn_) std::fputs("\n", stderr);
  drawn_ = false;
}

}  // namespace cliquevo::tools
