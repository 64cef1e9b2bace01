// SPDX-License-Identifier: BSD-3-Clause
// The view beside something that is no daemon of ours: whatever is sent on its channels, it goes on serving.
#include <chrono>
#include <csignal>
#include <functional>
#include <limits>
#include <netinet/in.h>
#include <random>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include <cliquevo/features_t.hpp>
#include <cliquevo/images_t.hpp>
#include <cliquevo/movers_t.hpp>
#include <cliquevo/pose_t.hpp>
#include <cliquevo/status_t.hpp>
#include <cliquevo/update_t.hpp>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr std::uint16_t kPort = 8470;

// What the view answers to a request of /metrics; empty: nothing.
std::string metrics() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(kPort);
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string out;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0) {
    const std::string request = "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1:8470\r\nConnection: close\r\n\r\n";
    static_cast<void>(::send(socket, request.data(), request.size(), MSG_NOSIGNAL));
    char part[4096];
    for (ssize_t n = 0; (n = ::recv(socket, part, sizeof part, 0)) > 0;) out.append(part, static_cast<std::size_t>(n));
  }
  ::close(socket);
  return out;
}

bool serves(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (metrics().find("cliquevo_view_info") != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

// Few messages wait at the view: those that come faster than it takes them would prove nothing.
void pause() { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }

image_t image(int width, int height, std::size_t bytes) {
  image_t out{};
  out.width = width;
  out.height = height;
  out.row_stride = width;
  out.pixelformat = image_t::PIXEL_FORMAT_GRAY;
  out.data.assign(bytes, 7);
  out.size = static_cast<std::int32_t>(bytes);
  return out;
}

void send_images(lcm::LCM& lcm, std::int64_t utime, std::int16_t type, const image_t& of) {
  images_t m{};
  m.utime = utime;
  m.n_images = 1;
  m.image_types = {type};
  m.images = {of};
  lcm.publish("VO_IMAGES", &m);
  pause();
}

TEST(ViewMessages, ImagesThatAreNotWhatTheySayAreLeftOut) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  lcm::LCM lcm(kUrl);
  test::Subprocess view({test::binary("cliquevo"), "view", "--lcm", kUrl, "--socket", ""});
  ASSERT_TRUE(serves(60.0));
  constexpr int kMost = std::numeric_limits<std::int32_t>::max();
  std::int64_t utime = 0;
  for (const std::int16_t type : {images_t::LEFT, images_t::RIGHT, images_t::DISPARITY, images_t::MASK_ZIPPED}) {
    for (const auto& [width, height] :
         {std::pair{64, 48}, {0, 0}, {-1, 5}, {5, -1}, {kMost, kMost}, {kMost, 1}, {1, kMost}, {8000, 8000}}) {
      for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{64 * 48}, std::size_t{2 * 64 * 48}}) {
        for (const int stride : {width, 0, -1, 127, kMost}) {
          image_t one = image(width, height, bytes);
          one.row_stride = stride;
          send_images(lcm, ++utime, type, one);
        }
      }
    }
  }
  EXPECT_TRUE(serves(60.0));
  view.send(SIGTERM);
  const test::Finished end = view.wait(30.0);
  EXPECT_EQ(end.exit_code, 0) << end.err;
}

// A message of every type with some bytes changed, cut off or added.
TEST(ViewMessages, DamagedMessagesAreNobodysFault) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  lcm::LCM lcm(kUrl);
  test::Subprocess view({test::binary("cliquevo"), "view", "--lcm", kUrl, "--socket", ""});
  ASSERT_TRUE(serves(60.0));
  std::mt19937 random(5);
  const auto send = [&](const char* channel, const auto& message) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    for (int round = 0; round < 60; ++round) {
      std::vector<std::uint8_t> changed = bytes;
      for (auto k = random() % 6; k > 0; --k)
        changed[8 + random() % (changed.size() - 8)] = static_cast<std::uint8_t>(random());
      if (random() % 4 == 0) changed.resize(random() % (changed.size() + 40) + 1);
      lcm.publish(channel, changed.data(), static_cast<unsigned>(changed.size()));
      pause();
    }
  };
  images_t images{};
  images.n_images = 2;
  images.image_types = {images_t::LEFT, images_t::MASK_ZIPPED};
  images.images = {image(16, 8, 128), image(16, 8, 30)};
  features_t features{};
  features.num_features = 3;
  features.x = features.y = features.from_x = features.from_y = features.disparity =
      features.error = {1.0F, 2.0F, 3.0F};
  features.role = {0, 2, 9};
  movers_t movers{};
  movers.num_movers = 1;
  movers.movers.resize(1);
  for (int round = 0; round < 5; ++round) {
    send("POSE_BODY", pose_t{});
    send("VO_STATUS", status_t{});
    send("VO_DELTA_CAMERA", update_t{});
    send("VO_FEATURES", features);
    send("VO_MOVERS", movers);
    send("VO_IMAGES", images);
  }
  EXPECT_TRUE(serves(60.0));
  view.send(SIGTERM);
  const test::Finished end = view.wait(30.0);
  EXPECT_EQ(end.exit_code, 0) << end.err;
}

}  // namespace
}  // namespace cliquevo
