// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/chunk_store.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <zlib.h>

namespace cliquevo::drivers {

namespace {

constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 30U;
constexpr std::size_t kStep = 1U << 18U;

}  // namespace

// A chunk on its way out of its compression.
struct ChunkStore::Open {
  std::int32_t number = -1;
  std::unique_ptr<Decompressor> stream;
  std::vector<std::uint8_t> in;
  std::size_t in_used = 0;
  std::uint64_t taken = 0;  // of the stored bytes
  std::vector<std::uint8_t> out;
  bool ended = false;
  bool damaged = false;

  // Until `wanted` bytes are there; false: they never will be.
  bool reach(std::uint64_t wanted, const Chunk& chunk, const FileBytes& file) {
    while (out.size() < wanted && !ended) advance(chunk, file);
    if (out.size() == chunk.size && chunk.crc != 0 && !checked_) {
      checked_ = true;
      damaged = crc32_z(0, out.data(), out.size()) != chunk.crc;
    }
    return !damaged && out.size() >= wanted;
  }

 private:
  bool checked_ = false;

  void advance(const Chunk& chunk, const FileBytes& file) {
    if (in_used == in.size() && taken < chunk.stored_size) {
      in.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kStep, chunk.stored_size - taken)));
      in_used = 0;
      if (!file.read(chunk.at + taken, in.data(), in.size())) {
        ended = true;
        return;
      }
      taken += in.size();
    }
    const std::size_t before = out.size();
    // A byte more than is claimed: where it is written, the claim was wrong.
    const std::uint64_t room = chunk.size + 1 - before;
    out.resize(before + static_cast<std::size_t>(std::min<std::uint64_t>(kStep, room)));
    const Decompressor::Step step = stream->step(std::span(in).subspan(in_used), std::span(out).subspan(before));
    out.resize(before + step.given);
    in_used += step.taken;
    const bool starved = step.taken == 0 && step.given == 0 && taken >= chunk.stored_size;
    if (step.broken || out.size() > chunk.size) {
      ended = true;
      out.resize(std::min<std::size_t>(out.size(), static_cast<std::size_t>(chunk.size)));
    }
    ended = ended || step.ended || starved;
  }
};

ChunkStore::ChunkStore(FileBytes file) : file_(std::move(file)) {}
ChunkStore::~ChunkStore() = default;
ChunkStore::ChunkStore(ChunkStore&&) noexcept = default;
ChunkStore& ChunkStore::operator=(ChunkStore&&) noexcept = default;

std::int32_t ChunkStore::add(const Chunk& chunk) {
  chunks_.push_back(chunk);
  chunks_.back().size = std::min(chunk.size, kLargestChunk);
  return count() - 1;
}

std::uint64_t ChunkStore::size(std::int32_t number) const {
  if (number < 0) return file_.size();
  const Chunk& chunk = chunks_[static_cast<std::size_t>(number)];
  return chunk.compression == Compression::none ? chunk.stored_size : chunk.size;
}

ChunkStore::Open* ChunkStore::open(std::int32_t number) {
  for (std::unique_ptr<Open>& one : open_) {
    if (one == nullptr || one->number != number) continue;
    std::swap(open_.front(), one);
    return open_.front().get();
  }
  std::swap(open_.front(), open_.back());
  // Its memory is used again.
  auto fresh = std::make_unique<Open>();
  if (open_.front() != nullptr) {
    fresh->in.swap(open_.front()->in);
    fresh->out.swap(open_.front()->out);
    fresh->in.clear();
    fresh->out.clear();
  }
  fresh->number = number;
  fresh->stream = make_decompressor(chunks_[static_cast<std::size_t>(number)].compression);
  if (fresh->stream == nullptr) return nullptr;
  open_.front() = std::move(fresh);
  return open_.front().get();
}

bool ChunkStore::is_intact(std::int32_t number) {
  if (number < 0) return true;
  const Chunk& chunk = chunks_[static_cast<std::size_t>(number)];
  if (chunk.compression == Compression::none) return true;
  Open* content = open(number);
  if (content == nullptr) return false;
  content->reach(chunk.size, chunk, file_);
  return !content->damaged;
}

bool ChunkStore::read(std::int32_t number, std::uint64_t at, void* out, std::size_t count) {
  if (number < 0) return file_.read(at, out, count);
  const Chunk& chunk = chunks_[static_cast<std::size_t>(number)];
  if (at > size(number) || count > size(number) - at) return false;
  if (chunk.compression == Compression::none) return file_.read(chunk.at + at, out, count);
  Open* content = open(number);
  if (content == nullptr || !content->reach(at + count, chunk, file_)) return false;
  std::memcpy(out, content->out.data() + at, count);
  return true;
}

}  // namespace cliquevo::drivers
