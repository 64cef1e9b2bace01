// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo view` as viewers see it that speak foxglove.websocket.v1: Foxglove's own client decodes every topic, one
// that is asleep holds up nobody, and what is hostile is put out.
#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <map>
#include <poll.h>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include "tests/hil/made_up_messages.h"
#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr int kMessages = 60;

template <typename Done>
bool wait_until(Done done, double seconds = 60.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

// `cliquevo view` of the messages on this network, as soon as it serves.
class View {
 public:
  explicit View(const std::vector<std::string>& options = {}) : program_(command(options)) {
    EXPECT_TRUE(wait_until([this] { return program_.printed().find('\n') != std::string::npos; }));
    const std::string printed = program_.printed();
    port_ = static_cast<std::uint16_t>(std::stoi(printed.substr(printed.rfind(':') + 1)));
  }
  std::uint16_t port() const { return port_; }
  std::string address() const { return "ws://127.0.0.1:" + std::to_string(port_) + "/"; }
  pid_t pid() const { return program_.pid(); }
  void end() {
    program_.send(SIGTERM);
    EXPECT_EQ(program_.wait(20.0).exit_code, 0);
  }

 private:
  static std::vector<std::string> command(const std::vector<std::string>& options) {
    std::vector<std::string> out{binary("cliquevo"), "view", "--lcm", kUrl, "--port", "0"};
    out.insert(out.end(), options.begin(), options.end());
    return out;
  }
  Subprocess program_;
  std::uint16_t port_ = 0;
};

void publish(lcm::LCM& lcm, int n, const images_t& images) {
  const odometry_t odometry = odometry_at(n);
  lcm.publish("VO_ODOMETRY", &odometry);
  if (n % 10 != 0) return;
  lcm.publish("VO_IMAGES", &images);
  const points_t points = points_at(n);
  lcm.publish("VO_POINTS", &points);
}

images_t with_camera(images_t m) {
  for (image_t& image : m.images) {
    const std::pair<const char*, const char*> camera[] = {{"fx_px", "50.5"},       {"fy_px", "51"},
                                                          {"cx_px", "20.25"},      {"cy_px", "15"},
                                                          {"baseline_m", "0.125"}, {"doffs_px", "0"}};
    for (const auto& [key, value] : camera) {
      image_metadata_t entry;
      entry.key = key;
      entry.value.assign(value, value + std::strlen(value));
      entry.n = static_cast<std::int32_t>(entry.value.size());
      image.metadata.push_back(entry);
    }
    image.nmetadata = static_cast<std::int32_t>(image.metadata.size());
  }
  return m;
}

using Topics = std::map<std::string, std::vector<json>>;

Topics topics_of(const std::string& lines) {
  Topics out;
  for (const std::string& line : lines_of(lines)) {
    if (line == "READY") continue;
    const json m = json::parse(line);
    out[m["topic"]].push_back(m);
  }
  return out;
}

std::int64_t stamp_us(const json& header) {
  return header["stamp"]["sec"].get<std::int64_t>() * 1'000'000 + header["stamp"]["nanosec"].get<std::int64_t>() / 1000;
}

void expect_odometry(const json& got, int n) {
  const odometry_t m = odometry_at(n);
  const json& o = got["message"];
  EXPECT_EQ(got["type"], "nav_msgs/msg/Odometry");
  EXPECT_EQ(got["stamp"], std::to_string(m.utime * 1000));
  EXPECT_EQ(stamp_us(o["header"]), m.utime);
  EXPECT_EQ(o["child_frame_id"], "base_link");
  const char* axes[3] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(o["pose"]["pose"]["position"][axes[i]].get<double>(), m.position[i]);
    EXPECT_EQ(o["pose"]["pose"]["orientation"][axes[i]].get<double>(), m.orientation[i + 1]);
    EXPECT_EQ(o["twist"]["twist"]["linear"][axes[i]].get<double>(), m.velocity[i]);
    EXPECT_EQ(o["twist"]["twist"]["angular"][axes[i]].get<double>(), m.rotation_rate[i]);
  }
  for (std::size_t k = 0; k < 36; ++k) {
    EXPECT_EQ(o["pose"]["covariance"][k].get<double>(), m.pose_covariance[k / 6][k % 6]);
    EXPECT_EQ(o["twist"]["covariance"][k].get<double>(), m.twist_covariance[k / 6][k % 6]);
  }
}

// What comes seldom: all of it arrives, with the camera that the images describe.
void expect_pictures(const Topics& topics) {
  for (const char* topic :
       {"/stereo/left/image_rect", "/stereo/left/camera_info", "/stereo/disparity", "/stereo/points2"}) {
    ASSERT_TRUE(topics.contains(topic)) << topic;
    EXPECT_EQ(topics.at(topic).size(), static_cast<std::size_t>(kMessages / 10)) << topic;
  }
  const json& left = topics.at("/stereo/left/image_rect").back()["message"];
  EXPECT_EQ(left["encoding"], "mono8");
  EXPECT_EQ(left["width"], 40);
  EXPECT_EQ(topics.at("/stereo/disparity").back()["message"]["encoding"], "32FC1");
  EXPECT_EQ(topics.at("/stereo/left/camera_info").back()["message"]["k"][0], 50.5);
  EXPECT_EQ(topics.at("/stereo/left/camera_info").back()["message"]["p"][2], 20.25);
  const int last = kMessages - 10;
  EXPECT_EQ(topics.at("/stereo/points2").back()["message"]["width"], points_at(last).num_points);
}

TEST(FoxgloveWebSocket, FoxglovesOwnClientDecodesEveryTopicToTheBit) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  View view;
  Subprocess client({"node", CLIQUEVO_PEERS_DIR "/foxglove_client.mjs", view.address(), std::to_string(kMessages)});
  ASSERT_TRUE(wait_until([&] { return client.printed().find("READY") != std::string::npos; }));
  lcm::LCM lcm(kUrl);
  for (int n = 0; n < kMessages; ++n) {
    publish(lcm, n, with_camera(images_at(n)));
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
  }
  const Finished done = client.wait(60.0);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const Topics topics = topics_of(done.out);
  ASSERT_EQ(topics.at("/odom").size(), static_cast<std::size_t>(kMessages));
  for (int n = 0; n < kMessages; ++n) expect_odometry(topics.at("/odom")[static_cast<std::size_t>(n)], n);
  for (const char* topic : {"/pose", "/tf", "/diagnostics"}) {
    EXPECT_EQ(topics.at(topic).size(), static_cast<std::size_t>(kMessages)) << topic;
  }
  EXPECT_EQ(topics.at("/tf_static").back()["message"]["transforms"][0]["child_frame_id"], "camera_left_optical_frame");
  EXPECT_GE(topics.at("/path").back()["message"]["width"], kMessages / 2);
  expect_pictures(topics);
  EXPECT_EQ(topics.at("serverInfo")[0]["message"]["name"].get<std::string>().rfind("cliquevo", 0), 0U);
  EXPECT_FALSE(topics.contains("status"));
  view.end();
}

// A WebSocket by hand, which can be as rude as it likes.
class Raw {
 public:
  explicit Raw(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    host_ = "127.0.0.1:" + std::to_string(port);
  }
  ~Raw() { ::close(socket_); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;

  // The answer's status.
  int shake_hands(const std::string& protocols = "foxglove.websocket.v1", const std::string& origin = "",
                  const std::string& path = "/") {
    std::string head =
        "GET " + path + " HTTP/1.1\r\nHost: " + host_ +
        "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Version: 13\r\n";
    if (!protocols.empty()) head += "Sec-WebSocket-Protocol: " + protocols + "\r\n";
    if (!origin.empty()) head += "Origin: " + origin + "\r\n";
    send(head + "\r\n");
    answer_ = receive_until("\r\n\r\n");
    return answer_.size() > 12 ? std::stoi(answer_.substr(9, 3)) : -1;
  }
  const std::string& answer() const { return answer_; }
  void send(const std::string& bytes) { static_cast<void>(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL)); }
  // A frame of the client's, masked with zeros. opcode: 1 text, 2 binary.
  void send_frame(const std::string& body, int opcode = 1, bool last = true) {
    std::string frame(1, static_cast<char>((last ? 0x80 : 0) | opcode));
    if (body.size() < 126) {
      frame += static_cast<char>(0x80 | static_cast<int>(body.size()));
    } else if (body.size() < 65536) {
      frame += static_cast<char>(0x80 | 126);
      frame += static_cast<char>(body.size() >> 8U);
      frame += static_cast<char>(body.size() & 255U);
    } else {
      frame += static_cast<char>(0x80 | 127);
      for (int shift = 56; shift >= 0; shift -= 8)
        frame += static_cast<char>(body.size() >> static_cast<unsigned>(shift));
    }
    send(frame + std::string(4, '\0') + body);
  }
  // What comes up to that text, or until nothing comes any more.
  std::string receive_until(const std::string& text, int patience_ms = 5000) {
    std::string got;
    char bytes[65536];
    pollfd ready{socket_, POLLIN, 0};
    while (got.find(text) == std::string::npos && ::poll(&ready, 1, patience_ms) > 0) {
      const ssize_t size = ::recv(socket_, bytes, sizeof bytes, 0);
      if (size <= 0) break;
      got.append(bytes, static_cast<std::size_t>(size));
    }
    return got;
  }
  // Whether the other side ends it.
  bool is_put_out() {
    char bytes[65536];
    pollfd ready{socket_, POLLIN, 0};
    while (::poll(&ready, 1, 5000) > 0) {
      const ssize_t size = ::recv(socket_, bytes, sizeof bytes, 0);
      if (size <= 0) return true;
      const unsigned first = static_cast<unsigned char>(bytes[0]);
      if (first == 0x88) return true;  // a close frame
    }
    return false;
  }

 private:
  int socket_;
  std::string host_;
  std::string answer_;
};

TEST(FoxgloveWebSocket, IsForThoseAloneWhoMayHaveThePage) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  View view({"--allow-origin", "http://studio.test:8080"});
  const auto status = [&](const std::string& protocols, const std::string& origin, const std::string& path = "/") {
    return Raw(view.port()).shake_hands(protocols, origin, path);
  };
  EXPECT_EQ(status("foxglove.websocket.v1", ""), 101);
  EXPECT_EQ(status("other, foxglove.websocket.v1", ""), 101);
  EXPECT_EQ(status("foxglove.websocket.v1", "http://127.0.0.1:" + std::to_string(view.port())), 101);
  EXPECT_EQ(status("foxglove.websocket.v1", "http://studio.test:8080"), 101);
  EXPECT_EQ(status("foxglove.websocket.v1", "http://evil.example"), 403);
  EXPECT_EQ(status("", "http://studio.test:8080", "/live"), 403) << "the page's own socket gives commands";
  EXPECT_EQ(status("foxglove.websocket.v1", "http://studio.test:8080", "/live"), 403);
  EXPECT_EQ(status("foxglove.websocket.v2", ""), 404);
  EXPECT_EQ(status("", ""), 404);
  Raw raw(view.port());
  ASSERT_EQ(raw.shake_hands(), 101);
  EXPECT_NE(raw.answer().find("Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n"), std::string::npos) << raw.answer();
  view.end();
}

TEST(FoxgloveWebSocket, WhatIsHostileIsPutOutAndTheViewGoesOn) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  View view;
  const auto put_out = [&](const std::string& body) {
    Raw raw(view.port());
    EXPECT_EQ(raw.shake_hands(), 101);
    raw.send_frame(body);
    return raw.is_put_out();
  };
  for (const char* body : {"", "nonsense", "[]", "{}", "{\"op\":7}", "{\"op\":\"subscribe\"}",
                           "{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":-1,\"channelId\":1}]}",
                           "{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":1e99,\"channelId\":1}]}",
                           "{\"op\":\"unsubscribe\",\"subscriptionIds\":[\"1\"]}"}) {
    EXPECT_TRUE(put_out(body)) << body;
  }
  EXPECT_TRUE(put_out(std::string(20'000, ' '))) << "too long";
  EXPECT_TRUE(put_out(std::string(15'000, '['))) << "deep";
  {
    Raw raw(view.port());  // one message in frames without end
    ASSERT_EQ(raw.shake_hands(), 101);
    raw.send_frame("{", 1, false);
    for (int i = 0; i < 40; ++i) raw.send_frame(std::string(1000, ' '), 0, false);
    EXPECT_TRUE(raw.is_put_out());
  }
  Raw raw(view.port());
  ASSERT_EQ(raw.shake_hands(), 101);
  raw.send_frame(std::string(1000, '\x01'), 2);  // a client's publishing: read over
  raw.send_frame("{\"op\":\"getParameters\"}");  // nor is that offered
  std::string many = "{\"op\":\"subscribe\",\"subscriptions\":[";
  for (int i = 0; i < 200; ++i) many += (i > 0 ? "," : "") + ("{\"id\":" + std::to_string(i) + ",\"channelId\":1}");
  raw.send_frame(many + "]}");
  EXPECT_NE(raw.receive_until("no more than 64 subscriptions").find("no more than 64"), std::string::npos);
  raw.send_frame("{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":900,\"channelId\":99}]}");
  EXPECT_NE(raw.receive_until("there is no channel 99").find("no channel 99"), std::string::npos);
  view.end();
}

std::int64_t resident_kb(pid_t process) {
  const std::string status = read_file("/proc/" + std::to_string(process) + "/status");
  return std::stoll(status.substr(status.find("VmRSS:") + 6));
}

// Large pictures to viewers that never read, beside one that does.
TEST(FoxgloveWebSocket, ViewersThatSleepSkipFramesAndNothingGrows) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  View view;
  std::vector<std::unique_ptr<Raw>> sleepers;
  for (int i = 0; i < 4; ++i) {
    sleepers.push_back(std::make_unique<Raw>(view.port()));
    ASSERT_EQ(sleepers.back()->shake_hands(), 101);
    std::string all = "{\"op\":\"subscribe\",\"subscriptions\":[";
    for (int k = 1; k <= 10; ++k) {
      all += (k > 1 ? "," : "") + ("{\"id\":" + std::to_string(k) + ",\"channelId\":" + std::to_string(k) + "}");
    }
    sleepers.back()->send_frame(all + "]}");
  }
  Subprocess client({"node", CLIQUEVO_PEERS_DIR "/foxglove_client.mjs", view.address(), "60"});
  ASSERT_TRUE(wait_until([&] { return client.printed().find("READY") != std::string::npos; }));
  lcm::LCM lcm(kUrl);
  images_t large{};
  large.n_images = 2;
  large.image_types = {images_t::LEFT, images_t::DISPARITY};
  large.images = {image(0, 1, image_t::PIXEL_FORMAT_GRAY, 640, 480),
                  image(0, 2, image_t::PIXEL_FORMAT_LE_GRAY16, 640, 480)};
  std::int64_t before_kb = 0;
  for (int n = 0; n < 120; ++n) {
    large.utime = large.images[0].utime = large.images[1].utime = odometry_at(n).utime;
    lcm.publish("VO_IMAGES", &large);
    const odometry_t odometry = odometry_at(n);
    lcm.publish("VO_ODOMETRY", &odometry);
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
    if (n == 40) before_kb = resident_kb(view.pid());
  }
  const Finished done = client.wait(60.0);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_LT(resident_kb(view.pid()) - before_kb, 20'000) << "80 frames of 1.5 MB to each of four that sleep";
  view.end();
}

}  // namespace
}  // namespace cliquevo::test
