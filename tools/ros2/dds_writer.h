// SPDX-License-Identifier: BSD-3-Clause
// A participant of ROS 2's network and its topics, with names and qualities of service as ROS 2 has them.
#pragma once

#include <cstdint>
#include <dds/dds.h>
#include <string>

#include "core/base/result.h"

namespace cliquevo::ros2 {

class DdsParticipant {
 public:
  // domain: ROS_DOMAIN_ID.
  static Result<DdsParticipant> join(std::uint32_t domain);
  DdsParticipant(DdsParticipant&& other) noexcept;
  DdsParticipant& operator=(DdsParticipant&& other) noexcept;
  ~DdsParticipant();

  enum class Kind {
    stream,  // reliable, volatile, keeps the last ones
    latched  // reliable, transient local: who comes later gets the last one
  };
  // topic: "/odom".
  Result<dds_entity_t> add_writer(const dds_topic_descriptor_t& type, const std::string& topic, Kind kind, int depth);

 private:
  explicit DdsParticipant(dds_entity_t entity) : entity_(entity) {}
  dds_entity_t entity_ = 0;
};

}  // namespace cliquevo::ros2
