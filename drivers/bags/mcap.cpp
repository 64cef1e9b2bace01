// SPDX-License-Identifier: BSD-3-Clause
// MCAP, read record by record: chunks and their message indexes are a few thousand of them, so no summary is needed,
// and a file whose writer died is read like any other.
#include <array>
#include <limits>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "drivers/bags/chunked_bag.h"
#include "drivers/bags/little_endian.h"
#include "drivers/bags/mcap_records.h"

namespace cliquevo::drivers {

namespace {

using namespace mcap;  // its records

constexpr std::uint64_t kMagicSize = 8;
constexpr std::uint64_t kRecordHead = 9;    // op, length
constexpr std::uint64_t kMessageHead = 22;  // channel, number, two times
constexpr std::uint64_t kMostOfDefinition = 1U << 20U;
constexpr std::uint64_t kMostOfIndex = 1U << 28U;

struct Record {
  std::uint8_t op = 0;
  std::uint64_t at = 0;    // of its content
  std::uint64_t size = 0;  // as claimed
};

TimestampNs stamp_of(std::uint64_t ns) {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<TimestampNs>::max() / 2);
  return static_cast<TimestampNs>(std::min(ns, kMost));
}

class Mcap final : public ChunkedBag {
 public:
  Mcap(std::string path, FileBytes file) : ChunkedBag(std::move(path), std::move(file)) {}
  std::string kind() const override { return "MCAP bag"; }

  Result<void> index() {
    std::uint64_t at = kMagicSize;
    while (const std::optional<Record> record = head(-1, at)) {
      if (record->op == kFooter) break;
      const bool torn = record->size > store_.file().size() - record->at;
      if (record->op != kMessageIndex) settle_chunk();
      if (!take(*record, -1, torn)) return too_many();
      at = record->at + record->size;
      if (torn) {
        note_damage("cut off: read up to its last whole message");
        break;
      }
    }
    settle_chunk();
    if (!walk_unindexed()) return too_many();
    define_missing();
    return settle();
  }

 private:
  Error too_many() const { return {"bag claims too many messages", path_, "copy it again: it is damaged"}; }

  std::optional<Record> head(std::int32_t chunk, std::uint64_t at) {
    std::array<std::uint8_t, kRecordHead> bytes{};
    if (!store_.read(chunk, at, bytes.data(), bytes.size())) return std::nullopt;
    LittleEndianReader reader(bytes);
    Record record;
    record.op = reader.number<std::uint8_t>();
    record.size = reader.number<std::uint64_t>();
    record.at = at + kRecordHead;
    return record;
  }

  // Of the file, or of what is in a chunk. false: too many messages.
  bool take(const Record& record, std::int32_t chunk, bool torn) {
    switch (record.op) {
      case kSchema:
      case kChannel:
        if (!torn) define(record, chunk);
        return true;
      case kMessage:
        return torn || take_message(record, chunk);
      case kChunk:
        if (chunk < 0) take_chunk(record, torn);
        return true;
      case kMessageIndex:
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
    if (!load(record, chunk, kMostOfDefinition)) return;
    LittleEndianReader reader(bytes_);
    const auto id = reader.number<std::uint16_t>();
    if (record.op == kSchema) {
      Schema schema;
      schema.name = reader.text();
      reader.text();  // its encoding
      schema.definition = reader.text();
      if (reader.ok()) schemas_[id] = std::move(schema);
      return;
    }
    const auto schema = schemas_.find(reader.number<std::uint16_t>());
    BagTopic topic;
    topic.name = reader.text();
    const std::string_view encoding = reader.text();
    if (!reader.ok()) return;
    topic.serialization = encoding == "cdr"    ? Serialization::cdr
                          : encoding == "ros1" ? Serialization::ros1
                                               : Serialization::other;
    if (schema != schemas_.end()) {
      topic.type = plain_type(schema->second.name);
      topic.definition = schema->second.definition;
    }
    define_channel(id, std::move(topic));
  }

  bool take_message(const Record& record, std::int32_t chunk) {
    std::array<std::uint8_t, kMessageHead> bytes{};
    if (record.size < bytes.size() || !store_.read(chunk, record.at, bytes.data(), bytes.size())) return true;
    LittleEndianReader reader(bytes);
    const auto channel = reader.number<std::uint16_t>();
    reader.number<std::uint32_t>();
    return add_message(channel, stamp_of(reader.number<std::uint64_t>()), record.at - kRecordHead, chunk);
  }

  void take_chunk(const Record& record, bool torn) {
    constexpr std::uint64_t kFixed = 8 + 8 + 8 + 4;
    constexpr std::uint64_t kMost = kFixed + 4 + 32 + 8;
    std::array<std::uint8_t, kMost> bytes{};
    const std::uint64_t there = std::min(store_.file().size() - record.at, record.size);
    const auto size = static_cast<std::size_t>(std::min(there, kMost));
    if (!store_.read(-1, record.at, bytes.data(), size)) return;
    LittleEndianReader reader(std::span<const std::uint8_t>(bytes).first(size));
    reader.bytes(16);
    Chunk chunk;
    chunk.size = reader.number<std::uint64_t>();
    chunk.crc = reader.number<std::uint32_t>();
    const std::string_view name = reader.text();
    const auto compression = compression_named(name);
    const auto stored = reader.number<std::uint64_t>();
    if (!reader.ok()) return;
    if (!compression || *compression == Compression::bz2) {
      note_damage(fmt::format("a chunk with unknown compression {}", printable(name)));
      return;
    }
    const std::uint64_t head_size = size - reader.left();
    chunk.at = record.at + head_size;
    chunk.stored_size = std::min(stored, there - head_size);
    chunk.compression = *compression;
    if (torn) chunk.crc = 0;
    open_chunk_ = store_.add(chunk);
  }

  bool take_index(const Record& record) {
    if (!open_chunk_ || !load(record, -1, kMostOfIndex)) return true;
    LittleEndianReader reader(bytes_);
    const auto channel = reader.number<std::uint16_t>();
    LittleEndianReader entries(reader.bytes(reader.number<std::uint32_t>()));
    chunk_is_indexed_ = chunk_is_indexed_ || entries.left() > 0;
    while (entries.left() >= 16) {
      const auto time = entries.number<std::uint64_t>();
      if (!add_message(channel, stamp_of(time), entries.number<std::uint64_t>(), *open_chunk_)) return false;
    }
    return true;
  }

  // The indexes behind a chunk have been read; where there are none, its content is looked at.
  void settle_chunk() {
    if (open_chunk_ && !chunk_is_indexed_) unindexed_.push_back(*open_chunk_);
    open_chunk_.reset();
    chunk_is_indexed_ = false;
  }

  bool walk(std::int32_t chunk, bool definitions_only) {
    std::uint64_t at = 0;
    while (const std::optional<Record> record = head(chunk, at)) {
      if (record->size > store_.size(chunk) - record->at) return true;
      const bool wanted = !definitions_only || record->op != kMessage;
      if (record->op == kMessage && wanted && !is_there(*record, chunk)) return true;
      if (wanted && !take(*record, chunk, false)) return false;
      at = record->at + record->size;
    }
    return true;
  }
  // Whether the record's last byte can be had: the end of a torn chunk is missing.
  bool is_there(const Record& record, std::int32_t chunk) {
    std::uint8_t last = 0;
    return record.size == 0 || store_.read(chunk, record.at + record.size - 1, &last, 1);
  }

  bool walk_unindexed() {
    for (const std::int32_t chunk : unindexed_) {
      if (!walk(chunk, false)) return false;
    }
    return true;
  }

  // A file without a summary has its channels in the chunks.
  void define_missing() {
    for (std::int32_t chunk = 0; chunk < store_.count() && misses_channels(); ++chunk) walk(chunk, true);
  }

  std::optional<Place> place_of(std::int32_t chunk, std::uint64_t at) override {
    if (at > store_.size(chunk)) return std::nullopt;
    const std::optional<Record> record = head(chunk, at);
    if (!record || record->op != kMessage || record->size < kMessageHead) return std::nullopt;
    if (record->size > store_.size(chunk) - std::min(record->at, store_.size(chunk))) return std::nullopt;
    return Place{record->at + kMessageHead, record->size - kMessageHead};
  }

  struct Schema {
    std::string name;
    std::string definition;
  };
  std::unordered_map<std::uint16_t, Schema> schemas_;
  std::optional<std::int32_t> open_chunk_;
  bool chunk_is_indexed_ = false;
  std::vector<std::int32_t> unindexed_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

Result<std::unique_ptr<Bag>> open_mcap(const std::string& path) {
  auto file = FileBytes::open(path);
  if (!file) return file.error();
  auto bag = std::make_unique<Mcap>(path, std::move(*file));
  if (auto ok = bag->index(); !ok) return ok.error();
  return std::unique_ptr<Bag>(std::move(bag));
}

}  // namespace cliquevo::drivers
