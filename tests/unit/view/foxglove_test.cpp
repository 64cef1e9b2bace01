// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tools/view/access.h"
#include "tools/view/foxglove_protocol.h"

namespace cliquevo::view {
namespace {

using nlohmann::json;

TEST(FoxgloveProtocol, IsOneOfTheSubprotocolsOffered) {
  for (const char* list : {"foxglove.websocket.v1", "a, foxglove.websocket.v1", " foxglove.websocket.v1 ,b"}) {
    EXPECT_TRUE(offers_foxglove(list)) << list;
  }
  for (const char* list : {"", "foxglove.websocket.v2", "xfoxglove.websocket.v1", "foxglove.websocket.v1 x", ", ,"}) {
    EXPECT_FALSE(offers_foxglove(list)) << list;
  }
}

TEST(FoxgloveProtocol, EveryTopicIsAdvertisedWithItsDefinition) {
  const json all = json::parse(foxglove_advertisement());
  EXPECT_EQ(all["op"], "advertise");
  ASSERT_EQ(all["channels"].size(), kTopics);
  for (const json& channel : all["channels"]) {
    const auto topic = topic_of_channel(channel["id"].get<std::uint32_t>());
    ASSERT_TRUE(topic);
    EXPECT_EQ(channel["topic"], topic_info(*topic).name);
    EXPECT_EQ(channel["encoding"], "cdr");
    EXPECT_EQ(channel["schemaEncoding"], "ros2msg");
    EXPECT_GT(channel["schema"].get<std::string>().size(), 20U) << channel["topic"];
  }
  EXPECT_FALSE(topic_of_channel(0));
  EXPECT_FALSE(topic_of_channel(kTopics + 1));
}

TEST(FoxgloveProtocol, RequestsAreReadAndWhatIsNoneIsRefused) {
  const auto subscribed = parse_foxglove_request(
      R"({"op":"subscribe","subscriptions":[{"id":4294967295,"channelId":2},{"id":0,"channelId":77}]})");
  ASSERT_TRUE(subscribed);
  ASSERT_EQ(subscribed->subscribe.size(), 2U);
  EXPECT_EQ(subscribed->subscribe[0].id, 4294967295U);
  EXPECT_EQ(subscribed->subscribe[1].channel, 77U);
  const auto ended = parse_foxglove_request(R"({"op":"unsubscribe","subscriptionIds":[3,4]})");
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->unsubscribe, (std::vector<std::uint32_t>{3, 4}));
  const auto other = parse_foxglove_request(R"({"op":"subscribeConnectionGraph"})");
  ASSERT_TRUE(other);
  EXPECT_TRUE(other->subscribe.empty() && other->unsubscribe.empty());
  for (const char* text : {"", "x", "[1]", "{}", R"({"op":null})", R"({"op":"subscribe"})",
                           R"({"op":"subscribe","subscriptions":{}})", R"({"op":"subscribe","subscriptions":[1]})",
                           R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
                           R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})",
                           R"({"op":"unsubscribe","subscriptionIds":[-1]})"}) {
    EXPECT_FALSE(parse_foxglove_request(text)) << text;
  }
  EXPECT_FALSE(parse_foxglove_request(std::string(kMostFoxgloveBytes + 1, ' ')));
}

TEST(FoxgloveProtocol, AMessagesHeadIsThirteenBytesLowestFirst) {
  const auto head = foxglove_message_head(0x01020304, 0x1122334455667788);
  const std::array<std::uint8_t, 13> expected{1,    0x04, 0x03, 0x02, 0x01, 0x88, 0x77,
                                              0x66, 0x55, 0x44, 0x33, 0x22, 0x11};
  EXPECT_EQ(head, expected);
}

TEST(Ros2Topics, KeepTheLastMessagesAndWhoIsSlowGoesOnWithThose) {
  Ros2Topics topics;
  const auto put = [&](std::uint8_t value) { topics.put(Topic::left, value, {value}); };
  std::int64_t next = topics.newest(Topic::left);
  EXPECT_FALSE(topics.take(Topic::left, next));
  put(1);
  put(2);
  std::int64_t late = topics.newest(Topic::left);
  EXPECT_EQ(topics.take(Topic::left, late)->stamp_ns, 2) << "who comes later begins with the last one";
  EXPECT_FALSE(topics.take(Topic::left, late));
  EXPECT_EQ(topics.take(Topic::left, next)->stamp_ns, 1);
  for (std::uint8_t value = 3; value < 100; ++value) put(value);
  const auto kept = topic_info(Topic::left).kept;
  for (std::size_t k = 0; k < kept; ++k) {
    const auto message = topics.take(Topic::left, next);
    ASSERT_TRUE(message);
    EXPECT_EQ(message->cdr->front(), 100 - kept + k);
  }
  EXPECT_FALSE(topics.take(Topic::left, next));
  EXPECT_FALSE(topics.wanted(Topic::left));
  topics.count_subscriber(Topic::left, 1);
  EXPECT_TRUE(topics.wanted(Topic::left));
}

Judgement ask(std::string_view target, std::string_view origin, std::string_view protocols, const AccessRules& rules) {
  return judge({"GET", target, "127.0.0.1:8470", origin, "", true, protocols}, rules);
}

TEST(Access, ViewersPassWhereThePageDoesAndFromOriginsThatWereNamed) {
  const AccessRules rules{8470, "", {"http://localhost:8080"}};
  EXPECT_TRUE(ask("/", "", kFoxgloveProtocol, rules).viewer);
  EXPECT_EQ(ask("/", "http://localhost:8080", kFoxgloveProtocol, rules).status, 200);
  EXPECT_EQ(ask("/", "http://localhost:8081", kFoxgloveProtocol, rules).status, 403);
  EXPECT_EQ(ask("/", "", "", rules).status, 404);
  EXPECT_EQ(ask("/live", "http://localhost:8080", kFoxgloveProtocol, rules).status, 403);
  EXPECT_FALSE(ask("/live", "", kFoxgloveProtocol, rules).viewer);
  const AccessRules open{8470, "0123456789abcdef0123456789abcdef", {"http://localhost:8080"}};
  EXPECT_EQ(ask("/", "http://localhost:8080", kFoxgloveProtocol, open).status, 403) << "the token is asked for too";
  EXPECT_EQ(ask("/?token=" + open.token, "http://localhost:8080", kFoxgloveProtocol, open).status, 200);
}

}  // namespace
}  // namespace cliquevo::view
