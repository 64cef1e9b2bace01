// SPDX-License-Identifier: BSD-3-Clause
// The pairs of a recording by number, wherever they lie; and the source that plays them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/calibration/calibration.h"
#include "drivers/frame_source.h"
#include "drivers/recording/recording_options.h"
#include "drivers/recording/stamps.h"

namespace cliquevo::drivers {

class PairStore {
 public:
  virtual ~PairStore() = default;
  virtual std::int64_t size() const = 0;
  // Where it is, for messages.
  virtual std::string name(std::int64_t i) const = 0;
  // Images (and what else is known) of pair i; index and stamp are the caller's. One thread at a time.
  virtual Result<void> load(std::int64_t i, StereoPair& pair) = 0;
  // Images that were taken although their decoder warned, so far.
  virtual std::int64_t warned() const { return 0; }
};

// Names of both cameras' images: folders, files or topics.
struct StreamNames {
  std::string first;
  std::string second;
};

// Numbers of the pairs that options choose of `count`.
Result<std::vector<std::int64_t>> choose_pairs(std::int64_t count, const RecordingOptions& options);

// Plays the store's pairs, those chosen already, with these stamps by the options: once, or to and fro; read ahead by a
// thread or not. A pair that is to be skipped is an error of next(); to and fro it is left out. Bayer mosaics become
// grey, by the options or where the images show it; the description states it. Where the first camera of the
// calibration is the right one, and the streams are numbered as its cameras are, so are their images; the calibration's
// notes say so.
std::unique_ptr<FrameSource> play_pairs(std::unique_ptr<PairStore> store, const StreamNames& streams,
                                        RisingStamps stamps, SourceInfo info, const RecordingOptions& options);
// Rate of the pairs that are played; 0 = unknown.
double rate_of(const RisingStamps& stamps);

// A calibration for the store's pairs (drivers/calibration/examine.h), of which it looks at the first, middle and last.
Result<StereoCalibration> calibrate(const CalibrationRequest& request, PairStore& store);

// A log or a folder of logs (drivers/recording/log_recording.cpp).
Result<std::unique_ptr<FrameSource>> open_logs(const std::vector<std::string>& files, const RecordingOptions& options);
// A bag or a folder of bags (drivers/recording/bag_recording.cpp).
Result<std::unique_ptr<FrameSource>> open_bags(const std::vector<std::string>& files, const RecordingOptions& options);
// The logs that a path means: itself, or those in the folder; empty = it means something else.
std::vector<std::string> find_logs(const std::string& path);

}  // namespace cliquevo::drivers
