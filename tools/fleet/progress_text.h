// SPDX-License-Identifier: BSD-3-Clause
// How far a fleet is: counts from the files of results alone, so that it can be read from any machine.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/fleet/plan.h"
#include "tools/fleet/store.h"

namespace cliquevo::tools::fleet {

struct Standing {
  std::size_t units = 0;
  std::size_t done = 0;
  std::size_t failed = 0;  // with a failure recorded and no result
  std::size_t done_since = 0;
  double frames_left = 0.0;
  double frames_since = 0.0;  // of the results since `since_ns`
  double elapsed_s = 0.0;     // since then

  std::size_t waiting() const { return units - done - failed; }
  // Nothing: no result yet to judge by.
  std::optional<double> units_a_minute() const;
  std::optional<double> left_s() const;
};

// since_ns: when the run began, 1970; its rate is that of the results since then. 0: of no run, without a rate.
Standing standing_of(const Plan& plan, Store& store, std::int64_t since_ns, std::int64_t now_ns);
// "56 of 120 units, 1 failed, 184 a minute, 0:20 left"
std::string standing_text(const Standing& standing);
// "1:02:03", "0:20"
std::string duration_text(double seconds);

// A line on stderr while units are computed: on a terminal it is overwritten each second, elsewhere a new one is
// printed every ten.
class ProgressLine {
 public:
  ProgressLine(const Plan& plan, const std::vector<std::size_t>& units, Store& store);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void update();
  void finish();

 private:
  Plan part_;  // of the units alone
  Store& store_;
  bool terminal_;
  bool drawn_ = false;
  std::int64_t begin_ns_;      // 1970
  std::int64_t next_mono_ns_;  // of the next line
};

std::int64_t now_unix_ns();

}  // namespace cliquevo::tools::fleet
