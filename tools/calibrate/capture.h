// SPDX-License-Identifier: BSD-3-Clause
// Collects views of a board with guidance: of live cameras the newest pair, of recordings every one.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "drivers/frame_source.h"
#include "tools/calibrate/capture_page.h"
#include "tools/calibrate/collect.h"
#include "tools/calibrate/guide.h"

namespace cliquevo::tools {

class Capture {
 public:
  // page: null = the terminal alone.
  Capture(drivers::FrameSource& source, const calibration::Board& board, const GuideOptions& options,
          CapturePage* page);
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  // Until it is enough, the source ends, a signal comes, or the page asks. May be called again to go on.
  Result<Collected> collect();

 private:
  class Pairs;
  class Lines;
  void look_at(const drivers::StereoPair& pair);

  calibration::Board board_;
  Guide guide_;
  CapturePage* page_;
  struct BoardFinder;
  std::unique_ptr<BoardFinder> finder_;
  std::unique_ptr<Pairs> pairs_;
  std::unique_ptr<Lines> lines_;
  Collected out_;
};

}  // namespace cliquevo::tools
