// SPDX-License-Identifier: BSD-3-Clause
// A subscriber of ROS 2's network by another vendor than the bridge's: eProsima's Fast DDS, which decodes as well.
#pragma once

#include <cstdint>
#include <fastcdr/Cdr.h>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cliquevo::test {

using eprosima::fastcdr::Cdr;

class FastDdsSubscriber {
 public:
  enum class Kind { stream, latched, best_effort };

  explicit FastDdsSubscriber(std::uint32_t domain);
  ~FastDdsSubscriber();
  FastDdsSubscriber(const FastDdsSubscriber&) = delete;
  FastDdsSubscriber& operator=(const FastDdsSubscriber&) = delete;

  // topic: "rt/odom"; type: as on the wire. `take` reads the message's fields, on a thread of the library, one message
  // at a time. What it throws counts as a message that cannot be decoded.
  void subscribe(const std::string& topic, const std::string& type, Kind kind, std::function<void(Cdr&)> take);
  // Of all topics.
  int undecodable() const;
  int incompatible() const;  // writers whose quality of service does not fit

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::test
