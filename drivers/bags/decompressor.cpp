// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/decompressor.h"

#include <algorithm>
#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

namespace cliquevo::drivers {

namespace {

class Zstd final : public Decompressor {
 public:
  Zstd() : stream_(ZSTD_createDStream()) {
    // A window of 128 MB, as its command line tool has it: a forged frame may ask for gigabytes.
    if (stream_ != nullptr) ZSTD_DCtx_setParameter(stream_, ZSTD_d_windowLogMax, 27);
  }
  ~Zstd() override { ZSTD_freeDStream(stream_); }
  Zstd(const Zstd&) = delete;
  Zstd& operator=(const Zstd&) = delete;
  bool ok() const { return stream_ != nullptr; }

  Step step(std::span<const std::uint8_t> in, std::span<std::uint8_t> out) override {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{out.data(), out.size(), 0};
    const std::size_t hint = ZSTD_decompressStream(stream_, &to, &from);
    return {from.pos, to.pos, hint == 0, ZSTD_isError(hint) != 0};
  }

 private:
  ZSTD_DStream* stream_;
};

class Lz4 final : public Decompressor {
 public:
  Lz4() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION)) != 0) context_ = nullptr;
  }
  ~Lz4() override { LZ4F_freeDecompressionContext(context_); }
  Lz4(const Lz4&) = delete;
  Lz4& operator=(const Lz4&) = delete;
  bool ok() const { return context_ != nullptr; }

  Step step(std::span<const std::uint8_t> in, std::span<std::uint8_t> out) override {
    std::size_t taken = in.size();
    std::size_t given = out.size();
    const std::size_t hint = LZ4F_decompress(context_, out.data(), &given, in.data(), &taken, nullptr);
    if (LZ4F_isError(hint) != 0) return {0, 0, false, true};
    return {taken, given, hint == 0, false};
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class Bz2 final : public Decompressor {
 public:
  Bz2() : ok_(BZ2_bzDecompressInit(&stream_, 0, 0) == BZ_OK) {}
  ~Bz2() override {
    if (ok_) BZ2_bzDecompressEnd(&stream_);
  }
  Bz2(const Bz2&) = delete;
  Bz2& operator=(const Bz2&) = delete;
  bool ok() const { return ok_; }

  Step step(std::span<const std::uint8_t> in, std::span<std::uint8_t> out) override {
    constexpr std::size_t kMost = 1U << 30U;
    const std::size_t in_size = std::min(in.size(), kMost);
    const std::size_t out_size = std::min(out.size(), kMost);
    stream_.next_in = const_cast<char*>(reinterpret_cast<const char*>(in.data()));  // read only, says its manual
    stream_.avail_in = static_cast<unsigned>(in_size);
    stream_.next_out = reinterpret_cast<char*>(out.data());
    stream_.avail_out = static_cast<unsigned>(out_size);
    const int state = BZ2_bzDecompress(&stream_);
    return {in_size - stream_.avail_in, out_size - stream_.avail_out, state == BZ_STREAM_END,
            state != BZ_OK && state != BZ_STREAM_END};
  }

 private:
  bz_stream stream_{};
  bool ok_;
};

template <typename T>
std::unique_ptr<Decompressor> made() {
  auto out = std::make_unique<T>();
  return out->ok() ? std::unique_ptr<Decompressor>(std::move(out)) : nullptr;
}

}  // namespace

std::optional<Compression> compression_named(std::string_view name) {
  if (name.empty() || name == "none") return Compression::none;
  if (name == "zstd") return Compression::zstd;
  if (name == "lz4") return Compression::lz4;
  if (name == "bz2") return Compression::bz2;
  return std::nullopt;
}

std::unique_ptr<Decompressor> make_decompressor(Compression kind) {
  switch (kind) {
    case Compression::zstd:
      return made<Zstd>();
    case Compression::lz4:
      return made<Lz4>();
    case Compression::bz2:
      return made<Bz2>();
    case Compression::none:
      break;
  }
  return nullptr;
}

bool decompress_block(Compression kind, std::span<const std::uint8_t> in, std::size_t most,
                      std::vector<std::uint8_t>& out) {
  constexpr std::size_t kAtOnce = 1U << 18U;
  constexpr std::size_t kMost = 1U << 30U;
  most = std::min(most, kMost);
  out.clear();
  const auto stream = make_decompressor(kind);
  if (stream == nullptr) return false;
  while (out.size() < most) {
    const std::size_t before = out.size();
    out.resize(std::min(most, before + kAtOnce));
    const Decompressor::Step step = stream->step(in, std::span(out).subspan(before));
    out.resize(before + step.given);
    if (step.broken) return false;
    if (step.ended) return true;
    if (step.taken == 0 && step.given == 0) return false;  // cut off
    in = in.subspan(step.taken);
  }
  return true;
}

}  // namespace cliquevo::drivers
