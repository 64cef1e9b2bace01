// SPDX-License-Identifier: BSD-3-Clause
// NumPy's archives (.npz): a zip file with an array (.npy) for each name.
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "drivers/calibration/document.h"
#include "drivers/calibration/zip_archive.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

using Kind = DocumentNode::Kind;

constexpr std::size_t kMostArrayBytes = 1U << 16U;  // larger are maps and points, no matrices
constexpr std::size_t kMostArrays = 200;
constexpr std::size_t kMostCells = 64;  // likewise
constexpr std::size_t kMostCharacters = 64;
constexpr std::string_view kArrayMark("\x93NUMPY", 6);

// What an array says of itself.
struct ArrayHead {
  char type = '?';  // f, i, u, b; U: text; O: what Python alone reads; ?: many in one
  std::size_t bytes = 0;
  bool big_endian = false;
  bool by_columns = false;
  std::vector<std::size_t> shape;
  std::size_t data_at = 0;
};

// What stands behind 'key': in the head.
std::string_view after_key(std::string_view head, std::string_view key) {
  const std::size_t at = head.find(fmt::format("'{}':", key));
  return at == std::string_view::npos ? std::string_view{} : trim(head.substr(at + key.size() + 3));
}

bool read_shape(std::string_view text, std::vector<std::size_t>& shape) {
  const std::size_t close = text.find(')');
  if (!text.starts_with("(") || close == std::string_view::npos) return false;
  for (const std::string_view word : split_words(text.substr(1, close - 1))) {
    const auto side = parse_integer(word);
    if (!side || *side < 0 || *side > static_cast<std::int64_t>(kMostArrayBytes) || shape.size() == 8) return false;
    shape.push_back(static_cast<std::size_t>(*side));
  }
  return true;
}

// Magic, version, the head's length in two bytes or (from version 2 on) four, and the head as Python writes a
// dictionary.
bool read_array_head(std::string_view data, ArrayHead& out) {
  if (!data.starts_with(kArrayMark) || data.size() < 12) return false;
  const auto byte = [&data](std::size_t i) { return static_cast<std::size_t>(static_cast<unsigned char>(data[i])); };
  const bool old = byte(6) == 1;
  if (byte(6) < 1 || byte(6) > 3) return false;
  const std::size_t length = byte(8) | byte(9) << 8U | (old ? 0 : byte(10) << 16U | byte(11) << 24U);
  const std::size_t begin = old ? 10 : 12;
  if (length > data.size() - begin) return false;
  const std::string_view head = data.substr(begin, length);
  out.data_at = begin + length;
  const std::string_view type = after_key(head, "descr");
  const std::size_t end = type.empty() ? std::string_view::npos : type.find('\'', 1);
  if (!type.starts_with("'") || end == std::string_view::npos || end < 3)
    return type.starts_with("[");  // of many types
  out.big_endian = type[1] == '>';
  out.type = type[2];
  const auto bytes = parse_integer(type.substr(3, end - 3));
  out.bytes = bytes && *bytes > 0 && *bytes <= 4096 ? static_cast<std::size_t>(*bytes) : 0;
  out.by_columns = after_key(head, "fortran_order").starts_with("True");
  return read_shape(after_key(head, "shape"), out.shape);
}

double number_at(const char* from, const ArrayHead& head) {
  const auto as = [from]<typename T>(T value) {
    std::memcpy(&value, from, sizeof(T));
    return static_cast<double>(value);
  };
  const bool is_signed = head.type == 'i';
  switch (head.bytes) {
    case 1:
      return is_signed ? as(std::int8_t{}) : as(std::uint8_t{});
    case 2:
      return is_signed ? as(std::int16_t{}) : as(std::uint16_t{});
    case 4:
      return head.type == 'f' ? as(float{}) : is_signed ? as(std::int32_t{}) : as(std::uint32_t{});
    default:
      return head.type == 'f' ? as(double{}) : is_signed ? as(std::int64_t{}) : as(std::uint64_t{});
  }
}

// Whether its cells are numbers that are read.
bool holds_numbers(const ArrayHead& head) {
  const bool whole = head.type == 'i' || head.type == 'u' || head.type == 'b';
  const bool small = head.bytes == 1 || head.bytes == 2;
  return !head.big_endian &&
         ((whole && small) || ((whole || head.type == 'f') && (head.bytes == 4 || head.bytes == 8)));
}

// Row-major numbers between blanks; rows of the last two sides are exchanged where columns come first.
std::string numbers_as_text(std::string_view cells, const ArrayHead& head, std::size_t count) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t from = i;
    if (head.by_columns) {
      std::size_t rest = i;
      std::size_t stride = count;
      from = 0;
      for (std::size_t side = head.shape.size(); side-- > 0;) {  // the last side moves fastest in what is made
        stride /= head.shape[side];
        from += rest % head.shape[side] * stride;
        rest /= head.shape[side];
      }
    }
    out += fmt::format("{}{}", i == 0 ? "" : " ", number_at(cells.data() + from * head.bytes, head));
  }
  return out;
}

// A word of one array cell: four bytes a character.
std::string word_of(std::string_view cell) {
  std::string out;
  for (std::size_t i = 0; i + 4 <= cell.size() && cell[i] != '\0'; i += 4) {
    const bool ascii = cell[i] >= ' ' && cell[i + 1] == '\0' && cell[i + 2] == '\0' && cell[i + 3] == '\0';
    out += ascii ? cell[i] : '?';
  }
  return out;
}

enum class Reading { done, passed_over, torn };

Reading read_array(const ZipMember& member, DocumentNode& node) {
  ArrayHead head;
  if (!read_array_head(member.data, head)) return Reading::torn;
  node.kind = Kind::scalar;
  const std::string_view cells = std::string_view(member.data).substr(head.data_at);
  if (head.type == 'U') {
    if (!head.shape.empty() || head.big_endian || head.bytes > kMostCharacters) return Reading::passed_over;
    if (cells.size() / 4 < head.bytes) return Reading::torn;
    node.scalar = word_of(cells.substr(0, 4 * head.bytes));
    return Reading::done;
  }
  if (!holds_numbers(head)) {  // a matrix that is none must not be passed over
    const std::string size = head.bytes > 0 ? std::to_string(head.bytes) : "";
    node.scalar = fmt::format("dtype={}{}{}", head.big_endian ? ">" : "", head.type, size);
    return Reading::done;
  }
  std::size_t count = 1;
  for (const std::size_t side : head.shape) {
    count *= side;
    if (count > kMostCells) return Reading::passed_over;
  }
  if (count == 0) {
    node.kind = Kind::empty;
    return Reading::done;
  }
  if (cells.size() / head.bytes < count) return Reading::torn;
  node.scalar = numbers_as_text(cells, head, count);
  return Reading::done;
}

}  // namespace

Result<Document> Document::parse_numpy(std::string_view bytes, const std::string& path) {
  const auto members = read_zip(bytes, path, kMostArrayBytes, kMostArrays);
  if (!members) return members.error();
  DocumentNode root;
  root.kind = Kind::map;
  for (const ZipMember& member : *members) {
    constexpr std::string_view kEnding = ".npy";
    if (!member.name.ends_with(kEnding)) continue;
    DocumentNode node;
    switch (read_array(member, node)) {
      case Reading::torn:
        return Error{"array is torn", fmt::format("{} ({})", path, printable(member.name.substr(0, 64))),
                     "write the archive again with np.savez"};
      case Reading::passed_over:
        continue;
      case Reading::done:
        break;
    }
    root.entries.push_back({member.name.substr(0, member.name.size() - kEnding.size()), std::move(node)});
  }
  return of(std::move(root), path);
}

}  // namespace cliquevo::drivers
