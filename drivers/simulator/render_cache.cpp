// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/render_cache.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

namespace fs = std::filesystem;

namespace {

constexpr char kMagic[8] = {'c', 'v', 'o', 'p', 'a', 'i', 'r', '1'};
constexpr const char* kPrefix = "simulator-";
constexpr const char* kNote = "options.txt";

struct Header {
  char magic[8];
  std::int32_t width, height;
  std::int64_t frame;
  std::uint64_t checksum;
};

std::size_t packed_size(int width, int height) {
  return (static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + 1) / 2 * 3;
}

std::uint64_t checksum(const std::uint8_t* data, std::size_t size) {
  std::uint64_t sum = size;
  std::size_t i = 0;
  for (; i + 8 <= size; i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, data + i, 8);
    sum = (sum ^ word) * 0x9e3779b97f4a7c15ULL;
    sum ^= sum >> 29;
  }
  for (; i < size; ++i) sum = (sum ^ data[i]) * 0x9e3779b97f4a7c15ULL;
  return sum;
}

void pack(const Image<std::uint16_t>& image, std::uint8_t* out) {
  std::uint32_t held = 0;
  bool half = false;
  for (int j = 0; j < image.height(); ++j) {
    const std::uint16_t* row = image.view().row(j);
    for (int i = 0; i < image.width(); ++i) {
      if (!half) {
        held = row[i];
      } else {
        const std::uint32_t both = held | static_cast<std::uint32_t>(row[i]) << 12;
        *out++ = static_cast<std::uint8_t>(both);
        *out++ = static_cast<std::uint8_t>(both >> 8);
        *out++ = static_cast<std::uint8_t>(both >> 16);
      }
      half = !half;
    }
  }
  if (half) {
    *out++ = static_cast<std::uint8_t>(held);
    *out++ = static_cast<std::uint8_t>(held >> 8);
    *out++ = 0;
  }
}

void unpack(const std::uint8_t* in, int width, int height, Image<std::uint16_t>& image) {
  image.resize(width, height);
  std::uint32_t both = 0;
  bool half = false;
  for (int j = 0; j < height; ++j) {
    std::uint16_t* row = image.view().row(j);
    for (int i = 0; i < width; ++i) {
      if (!half) {
        both = in[0] | static_cast<std::uint32_t>(in[1]) << 8 | static_cast<std::uint32_t>(in[2]) << 16;
        in += 3;
        row[i] = static_cast<std::uint16_t>(both & 4095U);
      } else {
        row[i] = static_cast<std::uint16_t>(both >> 12);
      }
      half = !half;
    }
  }
}

std::string store_root(const SimulatorOptions& options) {
  std::string root = options.cache_dir;
  const char* set = std::getenv("CLIQUEVO_CACHE");
  if (root.empty() && set != nullptr) root = set;
  if (root == "none") return {};
  if (!root.empty()) return root;
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
    return std::string(home) + "/.cache/cliquevo";
  return {};
}

std::string file_name(std::int64_t frame) { return fmt::format("{:06d}.pair", frame); }

std::uint64_t hash_of(const std::string& key) {
  return checksum(reinterpret_cast<const std::uint8_t*>(key.data()), key.size());
}

// A scene's folder as we make it: a folder, no link, named after the hash of its note.
bool is_scene(const fs::path& folder) {
  std::error_code error;
  const std::string name = folder.filename().string();
  if (!name.starts_with(kPrefix) || !fs::is_directory(fs::symlink_status(folder, error))) return false;
  constexpr std::uintmax_t kLongestNote = 1 << 16;
  const fs::path note = folder / kNote;
  if (!fs::is_regular_file(fs::symlink_status(note, error)) || fs::file_size(note, error) > kLongestNote) return false;
  std::ifstream file(note, std::ios::binary);
  const std::string key{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return key.starts_with("render=") && name.ends_with(fmt::format("-{:016x}", hash_of(key)));
}

// NNNNNN.pair, or what an interrupted store left of one: NNNNNN.pair.HOST.PROCESS.COUNT, all numbers.
bool is_pair(const fs::directory_entry& entry) {
  std::error_code error;
  const std::string name = entry.path().filename().string();
  const std::size_t digits = name.find_first_not_of("0123456789");
  return digits != std::string::npos && digits >= 6 && name.compare(digits, 5, ".pair") == 0 &&
         name.find_first_not_of("0123456789.", digits + 5) == std::string::npos &&
         fs::is_regular_file(entry.symlink_status(error));
}

template <typename Use>
void for_each_pair(const fs::path& folder, const Use& use) {
  std::error_code error;
  for (fs::directory_iterator file(folder, error), last; !error && file != last; file.increment(error)) {
    if (is_pair(*file)) use(*file);
  }
}

// Of a folder with anything else in it, that stays.
void remove_scene(const fs::path& folder) {
  std::vector<fs::path> pairs;
  for_each_pair(folder, [&](const fs::directory_entry& file) { pairs.push_back(file.path()); });
  std::error_code error;
  for (const fs::path& pair : pairs) fs::remove(pair, error);
  fs::remove(folder / kNote, error);
  fs::remove(folder, error);
}

// Removes the scene folders that were not used for longest until `limit` bytes suffice; returns what is free.
std::int64_t make_room(const fs::path& root, const fs::path& keep, std::int64_t limit) {
  struct Scene {
    fs::path path;
    fs::file_time_type used;
    std::int64_t bytes;
  };
  std::vector<Scene> scenes;
  std::int64_t total = 0;
  std::error_code error;
  for (fs::directory_iterator it(root, error), end; !error && it != end; it.increment(error)) {
    if (!is_scene(it->path())) continue;
    std::error_code ignored;
    Scene scene{it->path(), fs::last_write_time(it->path() / kNote, ignored), 0};
    for_each_pair(it->path(), [&](const fs::directory_entry& file) {
      std::error_code gone;
      const auto size = file.file_size(gone);
      if (!gone) scene.bytes += static_cast<std::int64_t>(size);
    });
    total += scene.bytes;
    if (scene.path != keep) scenes.push_back(scene);
  }
  std::sort(scenes.begin(), scenes.end(), [](const Scene& a, const Scene& b) { return a.used < b.used; });
  for (const Scene& scene : scenes) {
    if (total <= limit) break;
    remove_scene(scene.path);
    total -= scene.bytes;
  }
  return limit - total;
}

// Describes the folder; its time is that of the last use. Written whole or not at all: the folder is recognised by it.
void write_note(const OwnFolder& scene, const std::string& key) {
  if (scene.read(kNote, key.size()) == key) {
    scene.touch(kNote);
  } else {
    static_cast<void>(scene.write(kNote, key));  // without a note nobody removes the folder, and all else is as with it
  }
}

}  // namespace

std::string render_key(const SimulatorOptions& o) {
  std::string key = fmt::format("render={}\n", kRenderVersion);
  const auto add = [&](const char* name, auto value) { key += fmt::format("{}={}\n", name, value); };
  add("width", o.width);
  add("height", o.height);
  add("focal_px", o.focal_px);
  add("baseline_m", o.baseline_m);
  add("camera_height_m", o.camera_height_m);
  add("pitch_deg", o.pitch_deg);
  add("raw", o.raw);
  for (const double d : o.misalign_right_deg) add("misalign_right_deg", d);
  add("course", o.course);
  add("step_m", o.step_m);
  add("rate_hz", o.rate_hz);
  add("world_seed", o.world_seed);
  add("rocks", o.rocks);
  add("movers", o.movers);
  add("shadow", o.shadow);
  add("scene", o.scene);
  add("motion_blur", o.motion_blur);
  // Named only where it is there: stores made before it was know nothing of it.
  if (o.sway_deg > 0.0) add("sway_deg", o.sway_deg);
  if (o.railings) add("railings", o.railings);
  if (o.walls) add("walls", o.walls);
  if (o.glass) add("glass", o.glass);
  return key;
}

RenderCache::RenderCache(const SimulatorOptions& options) : width_(options.width), height_(options.height) {
  const std::string root = store_root(options);
  if (root.empty()) return;
  const auto shared = OwnFolder::open_shared(root);
  if (!shared) return;
  const std::string key = render_key(options);
  const std::uint64_t hash = hash_of(key);
  auto scene = shared->below(fmt::format("{}{}-{:016x}", kPrefix, options.course, hash));
  if (!scene) return;
  write_note(*scene, key);
  room_bytes_ = make_room(shared->path(), scene->path(), static_cast<std::int64_t>(options.cache_limit_gb * 1e9));
  folder_ = std::move(*scene);
}

bool RenderCache::load(std::int64_t frame, CleanPair& pair) const {
  if (!enabled()) return false;
  const std::size_t each = packed_size(width_, height_);
  const auto bytes = folder_->read(file_name(frame), sizeof(Header) + 2 * each);
  if (!bytes || bytes->size() != sizeof(Header) + 2 * each) return false;
  Header header{};
  std::memcpy(&header, bytes->data(), sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0 || header.width != width_ || header.height != height_ ||
      header.frame != frame)
    return false;
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes->data()) + sizeof header;
  if (checksum(data, 2 * each) != header.checksum) return false;
  unpack(data, width_, height_, pair.left);
  unpack(data + each, width_, height_, pair.right);
  return true;
}

void RenderCache::store(std::int64_t frame, const CleanPair& pair) const {
  if (!enabled()) return;
  const std::size_t each = packed_size(width_, height_);
  if (written_.load() + static_cast<std::int64_t>(2 * each) > room_bytes_) return;
  std::vector<std::uint8_t> bytes(sizeof(Header) + 2 * each);
  std::uint8_t* data = bytes.data() + sizeof(Header);
  pack(pair.left, data);
  pack(pair.right, data + each);
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.width = width_;
  header.height = height_;
  header.frame = frame;
  header.checksum = checksum(data, 2 * each);
  std::memcpy(bytes.data(), &header, sizeof header);
  // A store that is full or gone is as no cache.
  if (folder_->write(file_name(frame), std::span<const std::uint8_t>(bytes))) {
    written_ += static_cast<std::int64_t>(2 * each);
  }
}

}  // namespace cliquevo::drivers::sim
