// SPDX-License-Identifier: BSD-3-Clause
#include "tests/hil/fast_dds.h"

#include <atomic>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <list>

#include <gtest/gtest.h>

namespace cliquevo::test {

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

using Bytes = std::vector<char>;

// A type of which only the name is known here: messages come as they were on the wire.
class OpaqueType final : public dds::TopicDataType {
 public:
  explicit OpaqueType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 64;  // grows
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void*, rtps::SerializedPayload_t*) override { return false; }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return 0U; };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

struct Counts {
  std::atomic<int> undecodable{0};
  std::atomic<int> incompatible{0};
};

class Listener final : public dds::DataReaderListener {
 public:
  Listener(Counts& counts, std::function<void(Cdr&)> take) : counts_(counts), take_(std::move(take)) {}

  void on_data_available(dds::DataReader* reader) override {
    Bytes bytes;
    for (dds::SampleInfo info; reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK;) {
      if (!info.valid_data) continue;
      try {
        eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
        Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
        cdr.read_encapsulation();
        take_(cdr);
      } catch (const std::exception&) {
        ++counts_.undecodable;
      }
    }
  }
  void on_requested_incompatible_qos(dds::DataReader*, const dds::RequestedIncompatibleQosStatus&) override {
    ++counts_.incompatible;
  }

 private:
  Counts& counts_;
  std::function<void(Cdr&)> take_;
};

}  // namespace

struct FastDdsSubscriber::Impl {
  Counts counts;
  std::list<Listener> listeners;
  dds::DomainParticipant* participant = nullptr;
  dds::Subscriber* subscriber = nullptr;
};

FastDdsSubscriber::FastDdsSubscriber(std::uint32_t domain) : impl_(std::make_unique<Impl>()) {
  impl_->participant = dds::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<dds::DomainId_t>(domain), dds::PARTICIPANT_QOS_DEFAULT);
  if (impl_->participant != nullptr) {
    impl_->subscriber = impl_->participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  EXPECT_NE(impl_->subscriber, nullptr) << "Fast DDS does not start";
}

FastDdsSubscriber::~FastDdsSubscriber() {
  if (impl_->participant == nullptr) return;
  impl_->participant->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(impl_->participant);
}

void FastDdsSubscriber::subscribe(const std::string& topic, const std::string& type, Kind kind,
                                  std::function<void(Cdr&)> take) {
  dds::TypeSupport(new OpaqueType(type)).register_type(impl_->participant);
  dds::Topic* named = impl_->participant->create_topic(topic, type, dds::TOPIC_QOS_DEFAULT);
  dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
  qos.reliability().kind = kind == Kind::best_effort ? dds::BEST_EFFORT_RELIABILITY_QOS : dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = kind == Kind::latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 100;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  impl_->listeners.emplace_back(impl_->counts, std::move(take));
  EXPECT_NE(impl_->subscriber->create_datareader(named, qos, &impl_->listeners.back()), nullptr) << topic;
}

int FastDdsSubscriber::undecodable() const { return impl_->counts.undecodable; }
int FastDdsSubscriber::incompatible() const { return impl_->counts.incompatible; }

}  // namespace cliquevo::test
