// SPDX-License-Identifier: BSD-3-Clause
// rosbag2's sqlite3 storage: the tables topics and messages. Messages may be compressed one by one (zstd).
#include <filesystem>
#include <memory>
#include <sqlite3.h>
#include <system_error>
#include <unordered_map>

#include <fmt/format.h>

#include "drivers/bags/bag.h"
#include "drivers/bags/decompressor.h"

namespace cliquevo::drivers {

namespace {

constexpr int kLongestValue = 1 << 30;

struct CloseDatabase {
  void operator()(sqlite3* db) const { sqlite3_close_v2(db); }
};
struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
struct CloseBlob {
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};
using Statement = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

std::string text_of(sqlite3_stmt* row, int column) {
  const unsigned char* text = sqlite3_column_text(row, column);
  return text == nullptr ? std::string() : reinterpret_cast<const char*>(text);
}

// A path as a URI: read only, and where no writer has left a journal, without locks.
std::string uri_of(const std::string& path) {
  std::string out = "file:";
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' ||
                       c == '.' || c == '_' || c == '-';
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
  }
  std::error_code ec;
  const bool journal = std::filesystem::exists(path + "-wal", ec) || std::filesystem::exists(path + "-journal", ec);
  return out + (journal ? "?mode=ro" : "?mode=ro&immutable=1");
}

class SqliteBag final : public Bag {
 public:
  explicit SqliteBag(std::string path) { path_ = std::move(path); }
  std::string kind() const override { return "ROS 2 bag (sqlite3)"; }

  Result<void> index() {
    sqlite3* db = nullptr;
    const int opened = sqlite3_open_v2(uri_of(path_).c_str(), &db, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    db_.reset(db);
    if (opened != SQLITE_OK) return Error{"cannot open bag", path_, db != nullptr ? sqlite3_errmsg(db) : "no memory"};
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kLongestValue);
    // A schema may hold anything, triggers and views with functions too.
    sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    if (auto ok = read_topics(); !ok) return ok;
    return read_messages();
  }

  Result<void> read(const BagMessage& message, std::vector<std::uint8_t>& out, std::size_t most) override {
    const Error damaged{"cannot read message", path_ + ", " + topics_[message.topic].name,
                        "the bag is damaged there: copy it again"};
    sqlite3_blob* opened = nullptr;
    const int state =
        sqlite3_blob_open(db_.get(), "main", "messages", "data", static_cast<sqlite3_int64>(message.at), 0, &opened);
    const std::unique_ptr<sqlite3_blob, CloseBlob> blob(opened);
    if (state != SQLITE_OK) return damaged;
    const int size = sqlite3_blob_bytes(opened);
    // Of a compressed message, more than is wanted may have to be read.
    constexpr std::size_t kMagic = 4;
    constexpr std::size_t kEnough = 1U << 16U;
    const bool compressed = size >= static_cast<int>(kMagic) && begins_as_zstd(opened);
    const std::size_t needed = compressed ? std::max(most, kEnough) : most;
    std::vector<std::uint8_t>& target = compressed ? compressed_ : out;
    target.resize(std::min(needed, static_cast<std::size_t>(size)));
    if (sqlite3_blob_read(opened, target.data(), static_cast<int>(target.size()), 0) != SQLITE_OK) return damaged;
    if (!compressed) return {};
    const bool whole = decompress_block(Compression::zstd, target, most, out);
    return whole || out.size() >= most || most < SIZE_MAX ? Result<void>() : damaged;
  }

 private:
  static bool begins_as_zstd(sqlite3_blob* blob) {
    constexpr unsigned char kZstd[4] = {0x28, 0xb5, 0x2f, 0xfd};
    unsigned char begin[4] = {};
    return sqlite3_blob_read(blob, begin, 4, 0) == SQLITE_OK && std::equal(begin, begin + 4, kZstd);
  }

  Statement prepare(const char* query) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(db_.get(), query, -1, &statement, nullptr);
    return Statement(statement);
  }

  Result<void> read_topics() {
    const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics");
    if (!rows) return Error{"no ROS 2 bag", path_, "it is a database without a table of topics"};
    while (sqlite3_step(rows.get()) == SQLITE_ROW) {
      BagTopic topic;
      topic.name = text_of(rows.get(), 1);
      topic.type = plain_type(text_of(rows.get(), 2));
      topic.serialization = text_of(rows.get(), 3) == "cdr" ? Serialization::cdr : Serialization::other;
      numbers_[sqlite3_column_int64(rows.get(), 0)] = topic_number(std::move(topic));
    }
    return {};
  }

  // In the order in which they were written: sorting by time would have the whole table read first.
  Result<void> read_messages() {
    const Statement rows = prepare("SELECT id, topic_id, timestamp FROM messages ORDER BY id");
    if (!rows) return Error{"no ROS 2 bag", path_, "it is a database without a table of messages"};
    int state = SQLITE_OK;
    while ((state = sqlite3_step(rows.get())) == SQLITE_ROW) {
      const auto topic = numbers_.find(sqlite3_column_int64(rows.get(), 1));
      if (topic == numbers_.end()) continue;
      if (messages_.size() >= kMostBagMessages) {
        return Error{"bag claims too many messages", path_, "copy it again: it is damaged"};
      }
      messages_.push_back({sqlite3_column_int64(rows.get(), 2),
                           static_cast<std::uint64_t>(sqlite3_column_int64(rows.get(), 0)), topic->second, -1});
    }
    if (state != SQLITE_DONE) damage_ = "cut off or damaged: read up to its last whole message";
    if (messages_.empty()) return Error{"bag has no message", path_, "copy it again, or record one"};
    return {};
  }

  std::unique_ptr<sqlite3, CloseDatabase> db_;
  std::unordered_map<std::int64_t, std::uint32_t> numbers_;
  std::vector<std::uint8_t> compressed_;
};

}  // namespace

Result<std::unique_ptr<Bag>> open_sqlite_bag(const std::string& path) {
  auto bag = std::make_unique<SqliteBag>(path);
  if (auto ok = bag->index(); !ok) return ok.error();
  return std::unique_ptr<Bag>(std::move(bag));
}

}  // namespace cliquevo::drivers
