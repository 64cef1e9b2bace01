// SPDX-License-Identifier: BSD-3-Clause
// How far a long run is, on stderr: a bar on a terminal, a line every ten seconds elsewhere.
#pragma once

#include <cstdint>
#include <string>

namespace cliquevo::tools {

class Progress {
 public:
  // total: -1 = unknown.
  explicit Progress(std::int64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::int64_t done, double distance_m, const std::string& status);
  // Ends the bar's line; before anything else is printed.
  void finish();

 private:
  std::int64_t total_;
  bool terminal_;
  bool drawn_ = false;
  std::int64_t begin_ns_;
  std::int64_t last_ns_;
};

// "[=====>    ]  56/140  62.3 Hz  47.1 m  valid"
std::string progress_line(std::int64_t done, std::int64_t total, double rate_hz, double distance_m,
                          const std::string& status, bool bar);

}  // namespace cliquevo::tools
