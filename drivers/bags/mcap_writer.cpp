// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/mcap_writer.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <map>
#include <unistd.h>
#include <utility>
#include <vector>
#include <zlib.h>
#include <zstd.h>

#include "drivers/bags/mcap_records.h"

namespace cliquevo::drivers {

namespace {

using Bytes = std::vector<std::uint8_t>;

using namespace mcap;  // its records

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
constexpr std::size_t kChunkBytes = 4U << 20U;
constexpr std::int64_t kChunkTime_ns = 1'000'000'000;
constexpr int kCompressionLevel = 1;

template <typename T>
void put(Bytes& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    out.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
  }
}
void put_text(Bytes& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out.insert(out.end(), text.begin(), text.end());
}
void put_record(Bytes& out, Op op, std::span<const std::uint8_t> body) {
  out.push_back(op);
  put(out, std::uint64_t{body.size()});
  out.insert(out.end(), body.begin(), body.end());
}
std::uint32_t checksum(std::span<const std::uint8_t> bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

}  // namespace

struct McapWriter::Impl {
  struct IndexEntry {
    std::uint64_t time;
    std::uint64_t at;
  };

  ~Impl() {
    if (descriptor >= 0) ::close(descriptor);
    ZSTD_freeCCtx(packer);
  }

  Error failed(const std::string& why) {
    const bool cut = ::ftruncate(descriptor, static_cast<off_t>(size)) == 0;
    ::close(std::exchange(descriptor, -1));
    return {"cannot write bag", path, why + (cut ? ": it holds everything before" : ": its end is torn")};
  }

  // Whole, or cut off again.
  Result<void> append(std::span<const std::uint8_t> bytes) {
    if (descriptor < 0) return Error{"cannot write bag", path, "an earlier message did not fit"};
    std::span<const std::uint8_t> left = bytes;
    while (!left.empty()) {
      const ssize_t done = ::write(descriptor, left.data(), left.size());
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) return failed(std::strerror(errno));
      left = left.subspan(static_cast<std::size_t>(done));
    }
    size += bytes.size();
    crc = checksum(bytes, crc);
    return {};
  }

  // The chunk with the indexes of its channels, in one piece.
  Result<void> flush() {
    if (chunk.empty()) return {};
    packed.resize(ZSTD_compressBound(chunk.size()));
    const std::size_t packed_size =
        ZSTD_compressCCtx(packer, packed.data(), packed.size(), chunk.data(), chunk.size(), kCompressionLevel);
    if (ZSTD_isError(packed_size) != 0) return failed(ZSTD_getErrorName(packed_size));
    body.clear();
    put(body, chunk_first);
    put(body, chunk_last);
    put(body, std::uint64_t{chunk.size()});
    put(body, checksum(chunk));
    put_text(body, "zstd");
    put(body, std::uint64_t{packed_size});
    body.insert(body.end(), packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(packed_size));
    out.clear();
    put_record(out, kChunk, body);
    const std::uint64_t chunk_size = out.size();
    Bytes offsets;
    for (const auto& [channel, entries] : index) {
      put(offsets, channel);
      put(offsets, size + out.size());
      body.clear();
      put(body, channel);
      put(body, static_cast<std::uint32_t>(16 * entries.size()));
      for (const IndexEntry& entry : entries) {
        put(body, entry.time);
        put(body, entry.at);
      }
      put_record(out, kMessageIndex, body);
    }
    body.clear();
    put(body, chunk_first);
    put(body, chunk_last);
    put(body, size);
    put(body, chunk_size);
    put(body, static_cast<std::uint32_t>(offsets.size()));
    body.insert(body.end(), offsets.begin(), offsets.end());
    put(body, out.size() - chunk_size);
    put_text(body, "zstd");
    put(body, std::uint64_t{packed_size});
    put(body, std::uint64_t{chunk.size()});
    put_record(chunk_indexes, kChunkIndex, body);
    ++chunks;
    chunk.clear();
    index.clear();
    return append(out);
  }

  Bytes statistics() {
    Bytes counted;
    std::uint64_t all = 0;
    for (const auto& [channel, count] : counts) {
      put(counted, channel);
      put(counted, count);
      all += count;
    }
    body.clear();
    put(body, all);
    put(body, static_cast<std::uint16_t>(channels));
    put(body, static_cast<std::uint32_t>(channels));
    put(body, std::uint32_t{0});  // attachments
    put(body, std::uint32_t{0});  // metadata
    put(body, chunks);
    put(body, all > 0 ? first : 0);
    put(body, last);
    put(body, static_cast<std::uint32_t>(counted.size()));
    body.insert(body.end(), counted.begin(), counted.end());
    Bytes record;
    put_record(record, kStatistics, body);
    return record;
  }

  Result<void> summarise() {
    body.clear();
    put(body, crc);
    out.clear();
    put_record(out, kDataEnd, body);
    if (auto ok = append(out); !ok) return ok;
    const std::uint64_t summary_at = size;
    out.clear();
    Bytes groups;
    const Bytes counted = statistics();
    using Group = std::pair<Op, const Bytes*>;
    for (const auto& [op, records] : {Group{kSchema, &schema_records}, Group{kChannel, &channel_records},
                                      Group{kStatistics, &counted}, Group{kChunkIndex, &chunk_indexes}}) {
      if (records->empty()) continue;
      body.clear();
      put(body, static_cast<std::uint8_t>(op));
      put(body, summary_at + out.size());
      put(body, std::uint64_t{records->size()});
      put_record(groups, kSummaryOffset, body);
      out.insert(out.end(), records->begin(), records->end());
    }
    const std::uint64_t offsets_at = summary_at + out.size();
    out.insert(out.end(), groups.begin(), groups.end());
    out.push_back(kFooter);
    put(out, std::uint64_t{20});
    put(out, summary_at);
    put(out, offsets_at);
    put(out, checksum(out));  // of all from the summary's beginning
    out.insert(out.end(), kMagic.begin(), kMagic.end());
    return append(out);
  }

  int descriptor = -1;
  std::string path;
  ZSTD_CCtx* packer = ZSTD_createCCtx();
  std::uint64_t size = 0;
  std::uint32_t crc = 0;
  std::uint16_t channels = 0;
  std::uint32_t chunks = 0;
  Bytes schema_records;
  Bytes channel_records;
  Bytes chunk_indexes;
  std::map<std::uint16_t, std::uint64_t> counts;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::int64_t messages = 0;
  Bytes chunk;
  std::uint64_t chunk_first = 0;
  std::uint64_t chunk_last = 0;
  std::map<std::uint16_t, std::vector<IndexEntry>> index;  // of the chunk
  Bytes packed;
  Bytes body;
  Bytes out;
};

McapWriter::McapWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
McapWriter::McapWriter(McapWriter&&) noexcept = default;
McapWriter& McapWriter::operator=(McapWriter&&) noexcept = default;
McapWriter::~McapWriter() = default;
std::int64_t McapWriter::bytes() const { return static_cast<std::int64_t>(impl_->size); }
std::int64_t McapWriter::messages() const { return impl_->messages; }

Result<McapWriter> McapWriter::create(const std::string& path) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640);
  if (impl->descriptor < 0) {
    return Error{"cannot write bag", path,
                 errno == EEXIST ? "it is there already: name a new file" : std::string(std::strerror(errno))};
  }
  Bytes begin(kMagic.begin(), kMagic.end());
  Bytes body;
  put_text(body, "ros2");
  put_text(body, "cliquevo");
  put_record(begin, kHeader, body);
  if (auto ok = impl->append(begin); !ok) return ok.error();
  return McapWriter(std::move(impl));
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& type, const std::string& definition,
                                      bool latched) {
  Impl& m = *impl_;
  const std::uint16_t number = ++m.channels;  // of the channel, and of a schema of its own
  m.body.clear();
  put(m.body, number);
  put_text(m.body, type);
  put_text(m.body, "ros2msg");
  put_text(m.body, definition);
  put_record(m.schema_records, kSchema, m.body);
  put_record(m.chunk, kSchema, m.body);
  m.body.clear();
  put(m.body, number);
  put(m.body, number);
  put_text(m.body, topic);
  put_text(m.body, "cdr");
  Bytes metadata;
  put_text(metadata, "offered_qos_profiles");
  put_text(metadata, latched ? "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n"
                             : "- history: 1\n  depth: 10\n  reliability: 1\n  durability: 2\n");
  put(m.body, static_cast<std::uint32_t>(metadata.size()));
  m.body.insert(m.body.end(), metadata.begin(), metadata.end());
  put_record(m.channel_records, kChannel, m.body);
  put_record(m.chunk, kChannel, m.body);
  m.counts[number] = 0;
  return number;
}

Result<void> McapWriter::write(std::uint16_t channel, TimestampNs stamp_ns, std::span<const std::uint8_t> cdr) {
  Impl& m = *impl_;
  const auto time = static_cast<std::uint64_t>(std::max<TimestampNs>(0, stamp_ns));
  const bool begins = m.index.empty();
  m.chunk_first = begins ? time : std::min(m.chunk_first, time);
  m.chunk_last = begins ? time : std::max(m.chunk_last, time);
  m.first = m.messages == 0 ? time : std::min(m.first, time);
  m.last = std::max(m.last, time);
  m.index[channel].push_back({time, m.chunk.size()});
  m.chunk.push_back(kMessage);
  put(m.chunk, std::uint64_t{22 + cdr.size()});
  put(m.chunk, channel);
  put(m.chunk, static_cast<std::uint32_t>(m.counts[channel]++));
  put(m.chunk, time);
  put(m.chunk, time);
  m.chunk.insert(m.chunk.end(), cdr.begin(), cdr.end());
  ++m.messages;
  if (m.chunk.size() < kChunkBytes && m.chunk_last - m.chunk_first < kChunkTime_ns) return {};
  return m.flush();
}

Result<void> McapWriter::close() {
  Impl& m = *impl_;
  if (m.descriptor < 0) return Error{"cannot write bag", m.path, "an earlier message did not fit"};
  if (auto ok = m.flush(); !ok) return ok;
  if (auto ok = m.summarise(); !ok) return ok;
  if (::close(std::exchange(m.descriptor, -1)) != 0) return Error{"cannot write bag", m.path, std::strerror(errno)};
  return {};
}

}  // namespace cliquevo::drivers
