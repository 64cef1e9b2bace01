// SPDX-License-Identifier: BSD-3-Clause
// Where frames come from: something that fills store and topics on a thread of its own, and has a word on how it gets
// on.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/base/camera_model.h"
#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "tools/view/ros2_topics.h"
#include "tools/view/store.h"

namespace cliquevo::view {

// What stands above the pictures; all of it may change while it runs.
struct FeedState {
  std::string text;   // "processing", "at the end", "no messages yet"
  std::string error;  // what ended it
  bool done = false;
  std::int64_t frames = -1;  // in all, where known
  std::string health_json;   // of a daemon; empty = none
  std::string check_text;    // the calibration's self-check in a sentence
  std::string view_text;
  std::shared_ptr<const Bytes> mask;  // JPEG, 0 = no features there; nullptr = none
  bool level = false;                 // it is known how the camera sits on the vehicle: up is up
  std::optional<StereoModel> model;
};

class Feed {
 public:
  virtual ~Feed() = default;
  virtual bool live() const = 0;
  virtual std::string source() const = 0;
  // Until the source's end, an error or until stopped(); on a thread of its own.
  virtual void run(Store& store, Ros2Topics& topics, const std::function<bool()>& stopped) = 0;
  // Any thread.
  virtual FeedState state() const = 0;
};

// Messages of a daemon. T_body_camera: as far as no message states it. Fails where there is no route, in one line.
Result<std::unique_ptr<Feed>> open_lcm_feed(const std::string& url, const RigidTransform& T_body_camera);

}  // namespace cliquevo::view
