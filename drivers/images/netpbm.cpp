// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <optional>

#include "drivers/images/decode_image.h"

namespace cliquevo::drivers {

namespace {

bool is_space(std::uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// Numbers between white space and comments, which run from # to the end of the line.
class Tokens {
 public:
  explicit Tokens(Bytes file) : file_(file) {}

  std::optional<unsigned> number() {
    while (at_ < file_.size() && (is_space(file_[at_]) || file_[at_] == '#')) {
      if (file_[at_] == '#') {
        while (at_ < file_.size() && file_[at_] != '\n' && file_[at_] != '\r') ++at_;
      } else {
        ++at_;
      }
    }
    unsigned value = 0;
    const std::size_t begin = at_;
    for (; at_ < file_.size() && file_[at_] >= '0' && file_[at_] <= '9'; ++at_) {
      value = value * 10 + (file_[at_] - '0');
      if (value > 99'999'999) return std::nullopt;
    }
    return at_ == begin ? std::nullopt : std::optional(value);
  }
  void skip_one() { at_ = std::min(at_ + 1, file_.size()); }
  Bytes rest() const { return file_.subspan(at_); }

 private:
  Bytes file_;
  std::size_t at_ = 2;
};

struct NetpbmHeader {
  int width = 0;
  int height = 0;
  unsigned most = 0;  // the brightest value
  int channels = 1;
  bool text = false;
};

// Where the samples come from: binary (two bytes big-endian above 255) or decimal text.
class SampleReader {
 public:
  SampleReader(const NetpbmHeader& header, Tokens tokens) : header_(header), tokens_(tokens), data_(tokens.rest()) {}

  bool next(unsigned& value) {
    if (header_.text) {
      const auto number = tokens_.number();
      value = std::min(number.value_or(0), header_.most);
      return number.has_value();
    }
    if (header_.most > 255) {
      value = std::min(static_cast<unsigned>(data_[at_]) << 8U | data_[at_ + 1], header_.most);
      at_ += 2;
    } else {
      value = std::min<unsigned>(data_[at_++], header_.most);
    }
    return true;
  }

 private:
  const NetpbmHeader& header_;
  Tokens tokens_;
  Bytes data_;
  std::size_t at_ = 0;
};

// Values up to a power of two less one stay as they are, others are spread over the full range.
template <typename T>
std::string read_pixels(const NetpbmHeader& header, Tokens tokens, bool spread, ImageView<T> out) {
  const unsigned full = sizeof(T) == 1 ? 255U : 65535U;
  SampleReader samples(header, tokens);
  for (int y = 0; y < out.height; ++y) {
    T* row = out.row(y);
    for (int x = 0; x < out.width; ++x) {
      unsigned v[3] = {0, 0, 0};
      for (int c = 0; c < header.channels; ++c) {
        if (!samples.next(v[c])) return kTorn;
      }
      const unsigned grey = header.channels == 1 ? v[0] : grey_of_rgb(v[0], v[1], v[2]);
      row[x] = static_cast<T>(spread ? (grey * full + header.most / 2) / header.most : grey);
    }
  }
  return {};
}

}  // namespace

bool is_netpbm(Bytes file) {
  return file.size() >= 3 && file[0] == 'P' && (file[1] == '2' || file[1] == '3' || file[1] == '5' || file[1] == '6') &&
         (is_space(file[2]) || file[2] == '#');
}

std::string decode_netpbm(Bytes file, GreyPicture& picture) {
  Tokens tokens(file);
  const auto width = tokens.number();
  const auto height = tokens.number();
  const auto most = tokens.number();
  if (!width || !height || !most || *most < 1 || *most > 65535) return kTorn;
  if (std::string refused = refuse_size(*width, *height); !refused.empty()) return refused;
  tokens.skip_one();  // exactly one blank ends the header
  NetpbmHeader header{static_cast<int>(*width), static_cast<int>(*height), *most, 1, file[1] == '2' || file[1] == '3'};
  if (file[1] == '3' || file[1] == '6') header.channels = 3;
  const std::size_t samples = std::size_t{*width} * *height * static_cast<std::size_t>(header.channels);
  // Text takes two characters a sample, but for the last.
  const std::size_t least = header.text ? 2 * samples - 1 : samples * (header.most > 255 ? 2 : 1);
  if (tokens.rest().size() < least) return kTorn;
  if (header.most <= 255) {
    picture.bytes.resize(header.width, header.height);
    return read_pixels(header, tokens, header.most != 255, picture.bytes.view());
  }
  const bool whole_bits = std::has_single_bit(header.most + 1);
  picture.deep = true;
  // Writers that do not look at their data put 65535: no evidence.
  picture.bits_in_use = header.most == 65535 ? 0 : whole_bits ? std::bit_width(header.most) : 16;
  picture.words.resize(header.width, header.height);
  return read_pixels(header, tokens, !whole_bits, picture.words.view());
}

}  // namespace cliquevo::drivers
