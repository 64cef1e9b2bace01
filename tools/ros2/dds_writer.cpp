// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ros2/dds_writer.h"

#include <memory>
#include <string_view>
#include <utility>

namespace cliquevo::ros2 {

namespace {

struct DeleteQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, DeleteQos>;

}  // namespace

Result<DdsParticipant> DdsParticipant::join(std::uint32_t domain) {
  constexpr std::string_view kEnclave = "enclave=/;";
  const Qos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), kEnclave.data(), kEnclave.size());
  const dds_entity_t entity = dds_create_participant(domain, qos.get(), nullptr);
  if (entity < 0) {
    return Error{"cannot join the DDS domain", std::to_string(domain),
                 std::string(dds_strretcode(-entity)) + ": see CYCLONEDDS_URI, and that a network is up"};
  }
  return DdsParticipant(entity);
}

DdsParticipant::DdsParticipant(DdsParticipant&& other) noexcept : entity_(std::exchange(other.entity_, 0)) {}
DdsParticipant& DdsParticipant::operator=(DdsParticipant&& other) noexcept {
  std::swap(entity_, other.entity_);
  return *this;
}
DdsParticipant::~DdsParticipant() {
  if (entity_ > 0) dds_delete(entity_);
}

Result<dds_entity_t> DdsParticipant::add_writer(const dds_topic_descriptor_t& type, const std::string& topic, Kind kind,
                                                int depth) {
  const Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_durability(qos.get(), kind == Kind::latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  const std::string name = "rt" + topic;
  const dds_entity_t created = dds_create_topic(entity_, &type, name.c_str(), nullptr, nullptr);
  const dds_entity_t writer = created < 0 ? created : dds_create_writer(entity_, created, qos.get(), nullptr);
  if (writer < 0) return Error{"cannot publish ROS 2 topic", topic, dds_strretcode(-writer)};
  return writer;
}

}  // namespace cliquevo::ros2
