// SPDX-License-Identifier: BSD-3-Clause
// ROS 1's bags, version 2.0: records of a header (fields NAME=VALUE) and data. Read record by record, so that one whose
// writer died needs no reindexing.
#include <array>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "drivers/bags/chunked_bag.h"
#include "drivers/bags/little_endian.h"

namespace cliquevo::drivers {

namespace {

constexpr std::string_view kVersion = "#ROSBAG V2.0\n";
enum Op : std::uint8_t { kMessage = 0x02, kIndex = 0x04, kChunk = 0x05, kConnection = 0x07 };
constexpr std::uint64_t kMostOfHeader = 1U << 20U;
constexpr std::uint64_t kLargestIndex = 1U << 28U;

// A field's value; empty = it is not there.
std::span<const std::uint8_t> field(std::span<const std::uint8_t> header, std::string_view name) {
  LittleEndianReader reader(header);
  while (reader.left() > 0) {
    const auto one = reader.bytes(reader.number<std::uint32_t>());
    if (!reader.ok()) return {};
    const std::string_view text(reinterpret_cast<const char*>(one.data()), one.size());
    if (text.starts_with(name) && text.size() > name.size() && text[name.size()] == '=') {
      return one.subspan(name.size() + 1);
    }
  }
  return {};
}

std::string text_field(std::span<const std::uint8_t> header, std::string_view name) {
  const auto value = field(header, name);
  return {reinterpret_cast<const char*>(value.data()), value.size()};
}

template <typename T>
std::optional<T> number_field(std::span<const std::uint8_t> header, std::string_view name) {
  const auto value = field(header, name);
  if (value.size() != sizeof(T)) return std::nullopt;
  return LittleEndianReader(value).number<T>();
}

TimestampNs ros1_stamp(std::uint64_t seconds_and_ns) {
  return static_cast<TimestampNs>(seconds_and_ns & 0xffffffffU) * 1'000'000'000 +
         static_cast<TimestampNs>(seconds_and_ns >> 32U);
}

class Ros1Bag final : public ChunkedBag {
 public:
  Ros1Bag(std::string path, FileBytes file) : ChunkedBag(std::move(path), std::move(file)) {}
  std::string kind() const override { return "ROS 1 bag"; }

  Result<void> index() {
    std::array<char, kVersion.size()> version{};
    if (!store_.file().read(0, version.data(), version.size()) ||
        std::string_view(version.data(), version.size()) != kVersion) {
      return Error{"bag is of another version than 2.0", path_, "convert it with `rosbag fix`"};
    }
    std::uint64_t at = kVersion.size();
    while (at < store_.file().size()) {
      const std::optional<Record> record = record_at(-1, at);
      if (!record) {
        note_damage("cut off: read up to its last whole message");
        break;
      }
      const bool torn = record->size > store_.file().size() - record->at;
      if (record->op != kIndex) settle_chunk();
      if (!take(*record, -1, torn)) {
        return Error{"bag claims too many messages", path_, "copy it again: it is damaged"};
      }
      at = record->at + record->size;
      if (torn) {
        note_damage("cut off: read up to its last whole message");
        break;
      }
    }
    settle_chunk();
    for (const std::int32_t chunk : unindexed_) walk(chunk, false);
    define_missing();
    return settle();
  }

 private:
  struct Record {
    std::uint8_t op = 0;
    std::uint64_t at = 0;    // of its data
    std::uint64_t size = 0;  // as claimed
  };

  // Its header goes to header_.
  std::optional<Record> record_at(std::int32_t chunk, std::uint64_t at) {
    std::array<std::uint8_t, 4> count{};
    if (!store_.read(chunk, at, count.data(), count.size())) return std::nullopt;
    const auto size = LittleEndianReader(count).number<std::uint32_t>();
    if (size > kMostOfHeader) return std::nullopt;
    header_.resize(size);
    if (!store_.read(chunk, at + 4, header_.data(), size)) return std::nullopt;
    if (!store_.read(chunk, at + 4 + size, count.data(), count.size())) return std::nullopt;
    const auto op = number_field<std::uint8_t>(header_, "op");
    if (!op) return std::nullopt;
    return Record{*op, at + 8 + size, LittleEndianReader(count).number<std::uint32_t>()};
  }

  bool take(const Record& record, std::int32_t chunk, bool torn) {
    switch (record.op) {
      case kConnection:
        if (!torn) define(record, chunk);
        return true;
      case kMessage: {
        const auto connection = number_field<std::uint32_t>(header_, "conn");
        const auto time = number_field<std::uint64_t>(header_, "time");
        if (torn || !connection || !time) return true;
        return add_message(*connection, ros1_stamp(*time), record.at - 8 - header_.size(), chunk);
      }
      case kChunk:
        if (chunk < 0) take_chunk(record);
        return true;
      case kIndex:
        return chunk >= 0 || torn || take_index(record);
      default:
        return true;
    }
  }

  bool load(const Record& record, std::int32_t chunk, std::uint64_t most) {
    if (record.size > most) return false;
    bytes_.resize(static_cast<std::size_t>(record.size));
    return store_.read(chunk, record.at, bytes_.data(), bytes_.size());
  }

  void define(const Record& record, std::int32_t chunk) {
    const auto id = number_field<std::uint32_t>(header_, "conn");
    BagTopic topic;
    topic.name = text_field(header_, "topic");
    if (!id || knows_channel(*id) || !load(record, chunk, kMostOfHeader)) return;
    topic.type = text_field(bytes_, "type");
    topic.definition = text_field(bytes_, "message_definition");
    topic.serialization = Serialization::ros1;
    define_channel(*id, std::move(topic));
  }

  void take_chunk(const Record& record) {
    const std::string name = text_field(header_, "compression");
    const auto compression = compression_named(name);
    const auto size = number_field<std::uint32_t>(header_, "size");
    if (!compression || !size) {
      note_damage(fmt::format("a chunk with unknown compression {}", printable(name)));
      return;
    }
    Chunk chunk;
    chunk.at = record.at;
    chunk.stored_size = std::min(record.size, store_.file().size() - record.at);
    chunk.size = *size;
    chunk.compression = *compression;
    open_chunk_ = store_.add(chunk);
  }

  bool take_index(const Record& record) {
    const auto version = number_field<std::uint32_t>(header_, "ver");
    const auto connection = number_field<std::uint32_t>(header_, "conn");
    if (!open_chunk_ || version != 1U || !connection || !load(record, -1, kLargestIndex)) return true;
    chunk_is_indexed_ = true;
    LittleEndianReader entries(bytes_);
    while (entries.left() >= 12) {
      const auto time = entries.number<std::uint64_t>();
      if (!add_message(*connection, ros1_stamp(time), entries.number<std::uint32_t>(), *open_chunk_)) return false;
    }
    return true;
  }

  // The indexes behind a chunk have been read; where there are none, its content is looked at.
  void settle_chunk() {
    if (open_chunk_ && !chunk_is_indexed_) unindexed_.push_back(*open_chunk_);
    open_chunk_.reset();
    chunk_is_indexed_ = false;
  }

  void walk(std::int32_t chunk, bool definitions_only) {
    std::uint64_t at = 0;
    while (const std::optional<Record> record = record_at(chunk, at)) {
      const std::uint64_t end = store_.size(chunk);
      if (record->at > end || record->size > end - record->at) return;
      std::uint8_t last = 0;  // the end of a torn chunk is missing
      if (record->size > 0 && !definitions_only && !store_.read(chunk, record->at + record->size - 1, &last, 1)) return;
      if ((!definitions_only || record->op == kConnection) && !take(*record, chunk, false)) return;
      at = record->at + record->size;
    }
  }

  // A bag whose writer died has its connections in the chunks.
  void define_missing() {
    for (std::int32_t chunk = 0; chunk < store_.count() && misses_channels(); ++chunk) walk(chunk, true);
  }

  std::optional<Place> place_of(std::int32_t chunk, std::uint64_t at) override {
    const std::optional<Record> record = record_at(chunk, at);
    const std::uint64_t end = store_.size(chunk);
    if (!record || record->op != kMessage || record->at > end || record->size > end - record->at) return std::nullopt;
    return Place{record->at, record->size};
  }

  std::vector<std::uint8_t> header_;
  std::vector<std::uint8_t> bytes_;
  std::optional<std::int32_t> open_chunk_;
  bool chunk_is_indexed_ = false;
  std::vector<std::int32_t> unindexed_;
};

}  // namespace

Result<std::unique_ptr<Bag>> open_ros1_bag(const std::string& path) {
  auto file = FileBytes::open(path);
  if (!file) return file.error();
  auto bag = std::make_unique<Ros1Bag>(path, std::move(*file));
  if (auto ok = bag->index(); !ok) return ok.error();
  return std::unique_ptr<Bag>(std::move(bag));
}

}  // namespace cliquevo::drivers
