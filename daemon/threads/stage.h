// SPDX-License-Identifier: BSD-3-Clause
// A working thread of the pipeline: takes a slot, stamps it, works on it, records how long that took, and hands the
// slot on or gives it back.
#pragma once

#include "daemon/threads/pipeline_state.h"

namespace cliquevo::daemon {

struct StageRole {
  StageId id;
  Span span;
  const char* name;  // in errors
  ReturningThread returns;
  TimestampNs FrameStamps::*begin;
  TimestampNs FrameStamps::*end;
};

class Stage {
 public:
  Stage(PipelineState& state, rt::Handover& input, const StageRole& role) : state_(state), input_(input), role_(role) {}
  virtual ~Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  // Until its input is closed and empty.
  void run();

 protected:
  // Before the clock of the stage's own work runs.
  virtual void begin(const FrameSlot& slot) = 0;
  virtual Result<void> work(FrameSlot& slot) = 0;
  // true: the slot went on to another stage; false: it is to be given back.
  virtual bool hand_on(int index) = 0;

  PipelineState& state_;

 private:
  void process(int index);

  rt::Handover& input_;
  StageRole role_;
};

class StereoThread final : public Stage {
 public:
  explicit StereoThread(PipelineState& state);

 private:
  void begin(const FrameSlot& slot) override;
  Result<void> work(FrameSlot& slot) override;
  bool hand_on(int index) override;
};

class OdometryThread final : public Stage {
 public:
  explicit OdometryThread(PipelineState& state);

 private:
  void begin(const FrameSlot& slot) override;
  Result<void> work(FrameSlot& slot) override;
  bool hand_on(int index) override;

  Outgoing out_;  // of the frame in work
};

}  // namespace cliquevo::daemon
