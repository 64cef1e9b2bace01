// SPDX-License-Identifier: BSD-3-Clause
// Writes what a source delivers, and messages beside it, into an LCM event log: through a bounded queue to a thread of
// its own, so that a slow disk holds up nobody who does not want to be held up.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/frame_source.h"

namespace cliquevo::drivers {

struct RecorderOptions {
  std::string path;                  // of the log; with max_file_bytes a number comes before its extension
  std::int64_t max_file_bytes = 0;   // a new file when this one has so many; 0 = one file, however large
  std::int64_t max_total_bytes = 0;  // of all files and `older_files`: the oldest of our own go; 0 = no limit
  std::int64_t max_queue_bytes = std::int64_t{64} << 20;
  bool wait_when_full = false;           // hold up who adds pairs instead of leaving them out
  std::vector<std::string> older_files;  // oldest first: removed too where they are logs that we wrote
};

// The name of the first file that a recorder with these options writes.
std::string first_file_of(const RecorderOptions& options);
// Whether the file is one that a recorder wrote, by its content.
bool is_own_log(const std::string& path);

struct RecorderCounts {
  std::int64_t pairs = 0;     // written
  std::int64_t messages = 0;  // written
  std::int64_t left_out = 0;  // pairs and messages that found the queue full or the disk at its end
  std::int64_t bytes = 0;
  std::int64_t files = 0;
};

class Recorder {
 public:
  // Opens the first file and writes the calibration into it, as into every file.
  static Result<Recorder> start(const RecorderOptions& options, const SourceInfo& info);
  Recorder(Recorder&&) noexcept;
  Recorder& operator=(Recorder&&) noexcept;
  ~Recorder();

  // Copies it. utime: the log's time of the event [us]. false: left out. Any thread.
  bool add(const StereoPair& pair, std::int64_t utime);
  bool add(const std::string& channel, const std::uint8_t* data, std::size_t size, std::int64_t utime);
  RecorderCounts counts() const;
  // What ended the writing, if anything did.
  std::optional<Error> failure() const;
  // Writes what is queued and closes the file. An error: see failure().
  Result<void> stop();

 private:
  struct Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// The time under which a pair of this source is logged [us]: when it came where it is live, else its exposure, so that
// a log of a recording plays at the recording's pace.
std::int64_t log_utime(const SourceInfo& info, const StereoPair& pair);

}  // namespace cliquevo::drivers
