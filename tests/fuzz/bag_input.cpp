// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fuzz/bag_input.h"

#include <string>
#include <sys/mman.h>
#include <unistd.h>
#include <vector>

#include "drivers/bags/bag.h"
#include "drivers/bags/ros_messages.h"
#include "drivers/recording.h"
#include "drivers/recording/streams.h"
#include "tests/fuzz/expect.h"

namespace cliquevo::fuzz {

namespace {

void read_messages(const std::string& path) {
  const auto bag = drivers::open_bag(path);
  if (!bag) return expect_clear(bag.error());
  std::vector<std::uint8_t> bytes;
  int left = 200;
  for (const drivers::BagMessage& message : (*bag)->messages()) {
    expect(message.topic < (*bag)->topics().size(), "a message is of a topic");
    if (--left < 0) return;
    const auto read = (*bag)->read(message, bytes);
    if (!read) {
      expect_clear(read.error());
      continue;
    }
    const drivers::Serialization form = (*bag)->topics()[message.topic].serialization;
    const auto image = drivers::parse_image(bytes, form);
    expect(!image || image->data.size() <= bytes.size(), "an image lies in its message");
    drivers::parse_compressed_image(bytes, form);
    drivers::parse_camera_info(bytes, form);
  }
}

void play(const std::string& path) {
  drivers::RecordingOptions options;
  options.path = path;
  options.read_ahead = false;
  const auto streams = drivers::list_streams(options);
  if (!streams) expect_clear(streams.error());
  auto source = drivers::open_recording(options);
  if (!source) return expect_clear(source.error());
  drivers::StereoPair pair;
  for (int i = 0; i < 20; ++i) {
    const auto more = (*source)->next(pair);
    if (more.ok() && !*more) return;
    if (!more.ok()) expect_clear(more.error());
  }
}

}  // namespace

void play_bag(const std::uint8_t* data, std::size_t size) {
  static const int file = ::memfd_create("bag", MFD_CLOEXEC);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  expect(::ftruncate(file, 0) == 0 && ::pwrite(file, data, size, 0) == static_cast<ssize_t>(size), "a file");
  if (!drivers::looks_like_bag(path)) return;
  read_messages(path);
  play(path);
}

}  // namespace cliquevo::fuzz
