// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo ros2` as ROS 2's other middleware sees it: every field of every topic decoded by Fast DDS, none lost.
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "tests/hil/fast_dds.h"
#include "tests/hil/made_up_messages.h"
#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

#ifdef CLIQUEVO_LONG
constexpr int kMessages = 1000;
#else
constexpr int kMessages = 150;
#endif
constexpr auto kPeriod = std::chrono::microseconds(33'333);
constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr const char* kLoopback =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>"
    "</Interfaces></General></Domain></CycloneDDS>";
constexpr std::uint32_t kDomain = 37;
// The number of the message that has this stamp; -1: none has it.
int number_of(std::int32_t sec, std::uint32_t nanosec) {
  const std::int64_t us = std::int64_t{sec} * 1'000'000 + nanosec / 1000 - kFirstUs;
  return nanosec % 1000 == 0 && us >= 0 && us % 33'333 == 0 ? static_cast<int>(us / 33'333) : -1;
}

// What has arrived of a topic, in order; those before the first counted message are not.
struct Arrived {
  std::atomic<int> count{0};
  std::atomic<int> wrong{0};
  std::string first_wrong;

  void check(bool right, const std::string& what, int n) {
    if (!right && wrong++ == 0) first_wrong = what + " of message " + std::to_string(n);
  }
};

struct Header {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame;
};
Header take_header(Cdr& in) {
  Header out;
  in >> out.sec >> out.nanosec >> out.frame;
  return out;
}

std::vector<double> take_numbers(Cdr& in, std::size_t count) {
  std::vector<double> out(count);
  for (double& value : out) in >> value;
  return out;
}

bool same(const std::vector<double>& got, const double* expected) {
  return std::memcmp(got.data(), expected, got.size() * sizeof(double)) == 0;
}
bool same_quaternion(const std::vector<double>& xyzw, const double (&wxyz)[4]) {
  return std::abs(xyzw[3] - wxyz[0]) < 1e-12 && std::abs(xyzw[0] - wxyz[1]) < 1e-12 &&
         std::abs(xyzw[1] - wxyz[2]) < 1e-12 && std::abs(xyzw[2] - wxyz[3]) < 1e-12;
}

constexpr int kWarmUp = 1'000'000;  // number of the message that shows that all have found each other

void take_odometry(Cdr& in, Arrived& to) {
  const Header header = take_header(in);
  const int n = number_of(header.sec, header.nanosec);
  if (n == kWarmUp) return;
  to.check(n == to.count, "stamp or order", to.count);
  ++to.count;
  const odometry_t m = odometry_at(n);
  std::string child;
  in >> child;
  to.check(header.frame == "odom" && child == "base_link", "frames", n);
  to.check(same(take_numbers(in, 3), m.position), "position", n);
  to.check(same_quaternion(take_numbers(in, 4), m.orientation), "orientation", n);
  to.check(same(take_numbers(in, 36), &m.pose_covariance[0][0]), "pose covariance", n);
  to.check(same(take_numbers(in, 3), m.velocity), "velocity", n);
  to.check(same(take_numbers(in, 3), m.rotation_rate), "rotation rate", n);
  to.check(same(take_numbers(in, 36), &m.twist_covariance[0][0]), "twist covariance", n);
}

struct NamedTransform {
  Header header;
  std::string child;
  std::vector<double> translation;
  std::vector<double> rotation;
};
NamedTransform take_transform(Cdr& in) {
  NamedTransform out;
  std::uint32_t count = 0;
  in >> count;
  EXPECT_EQ(count, 1U);
  out.header = take_header(in);
  in >> out.child;
  out.translation = take_numbers(in, 3);
  out.rotation = take_numbers(in, 4);
  return out;
}

void take_tf(Cdr& in, Arrived& to) {
  const NamedTransform T = take_transform(in);
  const int n = number_of(T.header.sec, T.header.nanosec);
  if (n == kWarmUp) return;
  to.check(n == to.count, "stamp or order", to.count);
  ++to.count;
  const odometry_t m = odometry_at(n);
  to.check(T.header.frame == "odom" && T.child == "base_link", "frames", n);
  to.check(same(T.translation, m.position), "translation", n);
  to.check(same_quaternion(T.rotation, m.orientation), "rotation", n);
}

void take_diagnostics(Cdr& in, Arrived& to) {
  const Header header = take_header(in);
  const int n = number_of(header.sec, header.nanosec);
  if (n == kWarmUp) return;
  to.check(n == to.count, "stamp or order", to.count);
  ++to.count;
  const odometry_t m = odometry_at(n);
  std::uint32_t count = 0;
  std::uint8_t level = 9;
  std::string name, message, hardware;
  std::uint32_t values = 0;
  in >> count >> level >> name >> message >> hardware >> values;
  to.check(count == 1 && level == m.pose_is_guess && name == "cliquevo: odometry" && hardware == "cliquevo", "head", n);
  to.check(message == (m.status == 1 ? "valid" : "too few features"), "message", n);
  const std::vector<std::string> expected{"quality",         std::to_string(m.quality),
                                          "pose is a guess", m.pose_is_guess != 0 ? "yes" : "no",
                                          "reset counter",   std::to_string(m.reset_counter)};
  to.check(2 * values == expected.size(), "number of values", n);
  for (const std::string& text : expected) {
    std::string got;
    in >> got;
    to.check(got == text, text, n);
  }
}

void take_image(Cdr& in, bool left, Arrived& to) {
  const Header header = take_header(in);
  const int n = number_of(header.sec, header.nanosec);
  if (n == kWarmUp) return;
  ++to.count;
  std::uint32_t height = 0, width = 0, step = 0;
  std::string encoding;
  std::uint8_t big_endian = 9;
  std::vector<std::uint8_t> data;
  in >> height >> width >> encoding >> big_endian >> step >> data;
  const image_t m = images_at(n).images[left ? 0 : 1];
  to.check(header.frame == "camera_left_optical_frame" && height == 30 && width == 40 && big_endian == 0, "head", n);
  to.check(encoding == (left ? "mono8" : "32FC1") && step == (left ? 40U : 160U), "encoding", n);
  to.check(data.size() == std::size_t{step} * height, "size", n);
  if (left) return to.check(data == m.data, "pixels", n);
  for (std::size_t i = 0; i < data.size() / 4; ++i) {
    float px = 0.0F;
    std::memcpy(&px, data.data() + 4 * i, sizeof px);
    const int sixteenths = m.data[2 * i] | m.data[2 * i + 1] << 8;
    to.check(sixteenths == 0 ? std::isnan(px) : px == static_cast<float>(sixteenths) / 16.0F, "disparity", n);
  }
}

void take_points(Cdr& in, Arrived& to) {
  const Header header = take_header(in);
  const int n = number_of(header.sec, header.nanosec);
  if (n == kWarmUp) return;
  ++to.count;
  const points_t m = points_at(n);
  std::uint32_t height = 0, width = 0, fields = 0;
  in >> height >> width >> fields;
  to.check(header.frame == "base_link" && height == 1 && width == m.x.size() && fields == 5, "head", n);
  std::uint32_t expected_offset = 0;
  for (const char* expected : {"x", "y", "z", "sigma", "intensity"}) {
    std::string name;
    std::uint32_t offset = 0, count = 0;
    std::uint8_t type = 0;
    in >> name >> offset >> type >> count;
    to.check(name == expected && offset == expected_offset && type == 7 && count == 1, name, n);
    expected_offset += 4;
  }
  bool big_endian = true, dense = false;
  std::uint32_t point_step = 0, row_step = 0;
  std::vector<std::uint8_t> data;
  in >> big_endian >> point_step >> row_step >> data >> dense;
  to.check(!big_endian && dense && point_step == 20 && row_step == 20 * width && data.size() == row_step, "steps", n);
  for (std::size_t i = 0; i < std::min(m.x.size(), data.size() / 20); ++i) {
    const float expected[5] = {m.x[i], m.y[i], m.z[i], m.sigma[i], static_cast<float>(m.grey[i])};
    to.check(std::memcmp(expected, data.data() + 20 * i, 20) == 0, "point", n);
  }
}

template <typename Done>
void wait_until(Done done, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!done() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

std::string bridge_config() {
  const std::string path = scratch_dir() + "/config.yaml";
  std::ofstream(path) << "body: {translation_m: [0.25, 0.5, 0.75], roll_pitch_yaw_deg: [0, 0, 0]}\n";
  return path;
}

// All topics of the bridge.
struct Topics {
  Arrived odom, tf, diagnostics, left, disparity, points;
  std::atomic<int> warm_odom{0}, warm_tf{0}, warm_rest{0};
  std::vector<NamedTransform> fixed;
  FastDdsSubscriber subscriber{kDomain};

  Topics() {
    using Kind = FastDdsSubscriber::Kind;
    const auto on = [this](const char* topic, const char* type, Kind kind, std::function<void(Cdr&)> take) {
      subscriber.subscribe(topic, type, kind, std::move(take));
    };
    on("rt/odom", "nav_msgs::msg::dds_::Odometry_", Kind::stream, [this](Cdr& in) {
      ++warm_odom;
      take_odometry(in, odom);
    });
    on("rt/tf", "tf2_msgs::msg::dds_::TFMessage_", Kind::stream, [this](Cdr& in) {
      ++warm_tf;
      take_tf(in, tf);
    });
    on("rt/tf_static", "tf2_msgs::msg::dds_::TFMessage_", Kind::latched,
       [this](Cdr& in) { fixed.push_back(take_transform(in)); });
    on("rt/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_", Kind::stream, [this](Cdr& in) {
      ++warm_rest;
      take_diagnostics(in, diagnostics);
    });
    // As rviz2 does by default for what is large.
    on("rt/stereo/left/image_rect", "sensor_msgs::msg::dds_::Image_", Kind::stream,
       [this](Cdr& in) { take_image(in, true, left); });
    on("rt/stereo/disparity", "sensor_msgs::msg::dds_::Image_", Kind::best_effort,
       [this](Cdr& in) { take_image(in, false, disparity); });
    on("rt/stereo/points2", "sensor_msgs::msg::dds_::PointCloud2_", Kind::stream,
       [this](Cdr& in) { take_points(in, points); });
  }
  bool found() const { return warm_odom > 0 && warm_tf > 0 && warm_rest > 0; }
};

void expect_all(const Arrived& arrived, int count, const char* topic) {
  EXPECT_EQ(arrived.count, count) << topic;
  EXPECT_EQ(arrived.wrong, 0) << topic << ": " << arrived.first_wrong;
}

TEST(Ros2, AnotherVendorDecodesEveryFieldAndNoneIsLost) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  // Before there are threads.
  Subprocess bridge({binary("cliquevo"), "ros2", "--lcm", kUrl, "--domain", std::to_string(kDomain), "--images",
                     "--points", "--config", bridge_config()},
                    {{"CYCLONEDDS_URI", kLoopback}});
  Topics topics;
  lcm::LCM lcm(kUrl);
  ASSERT_TRUE(lcm.good());
  const odometry_t first = odometry_at(kWarmUp);
  wait_until(
      [&] {
        lcm.publish("VO_ODOMETRY", &first);
        return topics.found();
      },
      60.0);
  ASSERT_TRUE(topics.found()) << "the two find each other";
  std::this_thread::sleep_for(std::chrono::seconds(1));  // topics that have had no message yet
  auto due = std::chrono::steady_clock::now();
  for (int n = 0; n < kMessages; ++n, due += kPeriod) {
    const odometry_t odometry = odometry_at(n);
    lcm.publish("VO_ODOMETRY", &odometry);
    if (n % 15 == 0) {
      const images_t images = images_at(n);
      const points_t points = points_at(n);
      lcm.publish("VO_IMAGES", &images);
      lcm.publish("VO_POINTS", &points);
    }
    std::this_thread::sleep_until(due);
  }
  wait_until([&] { return topics.diagnostics.count == kMessages && topics.points.count == kMessages / 15; }, 5.0);
  bridge.send(SIGTERM);
  EXPECT_EQ(bridge.wait(10.0).exit_code, 0);
  expect_all(topics.odom, kMessages, "/odom");
  expect_all(topics.tf, kMessages, "/tf");
  expect_all(topics.diagnostics, kMessages, "/diagnostics");
  const int large = (kMessages + 14) / 15;
  expect_all(topics.left, large, "/stereo/left/image_rect");
  expect_all(topics.disparity, large, "/stereo/disparity");
  expect_all(topics.points, large, "/stereo/points2");
  EXPECT_EQ(topics.subscriber.undecodable(), 0);
  EXPECT_EQ(topics.subscriber.incompatible(), 0);
  ASSERT_EQ(topics.fixed.size(), 1U) << "latched: it came although the bridge had sent it before";
  EXPECT_EQ(topics.fixed[0].header.frame, "base_link");
  EXPECT_EQ(topics.fixed[0].child, "camera_left_optical_frame");
  EXPECT_EQ(topics.fixed[0].translation, (std::vector<double>{0.25, 0.5, 0.75}));
  for (const double part : topics.fixed[0].rotation) EXPECT_NEAR(std::abs(part), 0.5, 1e-9);
}

}  // namespace
}  // namespace cliquevo::test
