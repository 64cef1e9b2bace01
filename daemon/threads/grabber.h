// SPDX-License-Identifier: BSD-3-Clause
// The grab thread: takes pairs from the source at their pace and hands them to the stereo stage.
#pragma once

#include "daemon/threads/pipeline_state.h"

namespace cliquevo::daemon {

class Grabber {
 public:
  explicit Grabber(PipelineState& state) : state_(state) {}
  // Until the source's end, or stopped.
  void run();

 private:
  enum class Grabbed { pair, none, end };
  Grabbed grab_into(int index);
  void hand_on(int index);

  PipelineState& state_;
};

}  // namespace cliquevo::daemon
