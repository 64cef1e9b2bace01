// SPDX-License-Identifier: BSD-3-Clause
// Two GigE Vision cameras that deliver a recording over the real protocol (on Aravis' fake camera), with faults.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/frame_source.h"

namespace cliquevo::tools {

struct HilOptions {
  std::string left_address = "127.0.0.1";
  std::string right_address = "127.0.0.2";
  std::string left_serial = "HIL-LEFT";
  std::string right_serial = "HIL-RIGHT";
  double rate_hz = 10.0;  // until the receiver of the frames sets another
  bool pingpong = false;  // else silent after the last pair
  double loss = 0.0;      // share of the packets
  int drop_every = 0;     // every n-th frame of the right camera is not sent; 0 = none
  int swap_every = 0;     // every n-th frame of the right camera changes places with the one before; 0 = none
  double right_late_s = 0.0;
  std::string log;              // a line for each frame sent: stamp [us], L or R, number of the pair; empty = none
  double outage_every_s = 0.0;  // both cameras are gone ...
  double outage_s = 2.0;        // ... for so long, and back
};

struct HilCounts {
  std::int64_t left = 0;  // frames sent
  std::int64_t right = 0;
};

class HilCameras {
 public:
  // Reads all pairs of the source into memory. Frame 0 waits until both cameras are streamed; whenever nobody has taken
  // frames for a second, the play begins anew.
  static Result<HilCameras> start(drivers::FrameSource& source, const HilOptions& options);
  HilCameras(HilCameras&&) noexcept;
  ~HilCameras();

  // Takes both cameras off the network, and puts them back.
  void unplug();
  Result<void> plug_in();
  HilCounts counts() const;
  std::int64_t pairs() const;

 private:
  struct Impl;
  explicit HilCameras(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::tools
