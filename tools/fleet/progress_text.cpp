// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/progress_text.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <unistd.h>

#include <fmt/format.h>

#include "core/base/time.h"

namespace cliquevo::tools::fleet {

namespace {

constexpr std::int64_t kTerminalPeriodNs = 1'000'000'000;
constexpr std::int64_t kLinePeriodNs = 10'000'000'000;
constexpr double kUnknownFrames = 1000.0;  // of a recording that does not say; only shares of the time depend on it

Plan part_of(const Plan& plan, const std::vector<std::size_t>& units) {
  Plan out;
  out.recordings = plan.recordings;
  for (const std::size_t k : units) out.units.push_back(plan.units[k]);
  return out;
}

}  // namespace

std::int64_t now_unix_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::optional<double> Standing::units_a_minute() const {
  if (done_since == 0 || elapsed_s <= 0.0) return std::nullopt;
  return 60.0 * static_cast<double>(done_since) / elapsed_s;
}

// By frames: recordings are not equally long.
std::optional<double> Standing::left_s() const {
  if (frames_since <= 0.0 || elapsed_s <= 0.0) return std::nullopt;
  return frames_left / (frames_since / elapsed_s);
}

Standing standing_of(const Plan& plan, Store& store, std::int64_t since_ns, std::int64_t now_ns) {
  Standing out;
  out.units = plan.units.size();
  std::int64_t last_ns = 0;
  for (const Unit& unit : plan.units) {
    const std::int64_t known = plan.recording_of(unit).frames;
    const double frames = known > 0 ? static_cast<double>(known) : kUnknownFrames;
    const auto written = store.written_ns(unit.key, Part::result);
    if (!written) {
      // An older one is tried again by this run.
      const auto failure = store.written_ns(unit.key, Part::failure);
      const bool failed = failure && *failure >= since_ns;
      out.failed += failed ? 1 : 0;
      out.frames_left += failed ? 0.0 : frames;
      continue;
    }
    ++out.done;
    last_ns = std::max(last_ns, *written);
    if (since_ns <= 0 || *written < since_ns) continue;
    ++out.done_since;
    out.frames_since += frames;
  }
  // When all is done the time stands still.
  const std::int64_t end_ns = out.waiting() == 0 && last_ns > since_ns ? last_ns : now_ns;
  if (since_ns > 0) out.elapsed_s = static_cast<double>(end_ns - since_ns) * 1e-9;
  return out;
}

std::string duration_text(double seconds) {
  const auto all = static_cast<std::int64_t>(std::ceil(std::max(0.0, seconds)));
  const std::int64_t hours = all / 3600;
  const std::int64_t minutes = all / 60 % 60;
  return hours > 0 ? fmt::format("{}:{:02}:{:02}", hours, minutes, all % 60)
                   : fmt::format("{}:{:02}", minutes, all % 60);
}

std::string standing_text(const Standing& s) {
  std::string out = fmt::format("{} of {} units", s.done, s.units);
  if (s.failed > 0) out += fmt::format(", {} failed", s.failed);
  if (const auto rate = s.units_a_minute()) out += fmt::format(", {:.3g} a minute", *rate);
  if (s.waiting() == 0) return out;
  const auto left = s.left_s();
  return out + (left ? fmt::format(", {} left", duration_text(*left)) : std::string(", time left not known yet"));
}

ProgressLine::ProgressLine(const Plan& plan, const std::vector<std::size_t>& units, Store& store)
    : part_(part_of(plan, units)),
      store_(store),
      terminal_(::isatty(STDERR_FILENO) == 1),
      begin_ns_(now_unix_ns()),
      next_mono_ns_(monotonic_ns() + (terminal_ ? kTerminalPeriodNs : kLinePeriodNs)) {}

ProgressLine::~ProgressLine() { finish(); }

void ProgressLine::update() {
  const std::int64_t now_ns = monotonic_ns();
  if (now_ns < next_mono_ns_) return;
  const std::string line = standing_text(standing_of(part_, store_, begin_ns_, now_unix_ns()));
  std::fputs((terminal_ ? fmt::format("\r{}\033[K", line) : line + "\n").c_str(), stderr);
  std::fflush(stderr);
  drawn_ = terminal_;
  // Looking at very many units takes time: a tenth of it at most.
  const std::int64_t after_ns = monotonic_ns();
  next_mono_ns_ = after_ns + std::max(terminal_ ? kTerminalPeriodNs : kLinePeriodNs, 9 * (after_ns - now_ns));
}

void ProgressLine::finish() {
  if (drawn_) std::fputs("\n", stderr);
  drawn_ = false;
}

}  // namespace cliquevo::tools::fleet
