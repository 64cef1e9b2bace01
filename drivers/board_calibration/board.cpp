// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/board.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace cliquevo::calibration {

namespace {

struct KindRow {
  BoardKind kind;
  const char* name;
  int least;  // columns and rows
  double ratio;
};

constexpr std::array<KindRow, 4> kKinds{{{BoardKind::chessboard, "chessboard", 3, 0.0},
                                         {BoardKind::charuco, "charuco", 3, 0.75},
                                         {BoardKind::aprilgrid, "aprilgrid", 1, 0.3},
                                         {BoardKind::circles, "circles", 3, 0.0}}};
constexpr int kMostCorners = 10'000;
constexpr double kLeastSize_m = 1e-4;
constexpr double kMostSize_m = 10.0;

const KindRow& row_of(BoardKind kind) {
  for (const KindRow& row : kKinds) {
    if (row.kind == kind) return row;
  }
  return kKinds[0];
}

template <typename T>
bool parse_whole(std::string_view text, T& value) {
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failed == std::errc{} && end == text.data() + text.size();
}

std::vector<std::string_view> split(std::string_view text, char by) {
  std::vector<std::string_view> out;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(by, at), text.size());
    out.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

// Corners of the grid, across and down.
std::array<int, 2> grid_of(const Board& board) {
  switch (board.kind) {
    case BoardKind::charuco:
      return {board.columns - 1, board.rows - 1};
    case BoardKind::aprilgrid:
      return {2 * board.columns, 2 * board.rows};
    case BoardKind::chessboard:
    case BoardKind::circles:
      break;
  }
  return {board.columns, board.rows};
}

// Place along one axis of an aprilgrid: tags and gaps take turns.
double tag_side(const Board& board, int index) {
  const int tag = index / 2;
  return board.size_m * (tag * (1.0 + board.ratio) + index % 2);
}

}  // namespace

const char* board_kind_name(BoardKind kind) { return row_of(kind).name; }

int Board::corner_count() const {
  const auto [across, down] = grid_of(*this);
  return across * down;
}

Eigen::Vector3d Board::corner(int id) const {
  if (kind == BoardKind::aprilgrid) {
    // Four corners a tag, counter-clockwise from its lower left; y upwards, as Kalibr has it.
    const int tag = id / 4;
    const int at = id % 4;
    const int column = 2 * (tag % columns) + (at == 1 || at == 2 ? 1 : 0);
    const int row = 2 * (tag / columns) + (at >= 2 ? 1 : 0);
    return {tag_side(*this, column), tag_side(*this, row), 0.0};
  }
  const int across = grid_of(*this)[0];
  const int row = id / across;
  return {size_m * (id % across), size_m * row, 0.0};
}

Eigen::Vector2d Board::half_extent() const {
  const auto [across, down] = grid_of(*this);
  if (kind == BoardKind::aprilgrid) return {0.5 * tag_side(*this, across - 1), 0.5 * tag_side(*this, down - 1)};
  return {0.5 * size_m * (across - 1), 0.5 * size_m * (down - 1)};
}

Eigen::Vector2d Board::middle() const { return half_extent(); }  // the first corner is at 0, 0

std::string Board::text() const {
  const std::string head = fmt::format("{}:{}x{}:{}", board_kind_name(kind), columns, rows, size_m);
  return ratio > 0.0 ? fmt::format("{}:{}", head, ratio) : head;
}

Result<Board> parse_board(const std::string& text) {
  const auto bad = [&](std::string remedy) { return Error{"wrong board", text, std::move(remedy)}; };
  const std::vector<std::string_view> parts = split(text, ':');
  const KindRow* row = nullptr;
  for (const KindRow& k : kKinds) {
    if (parts[0] == k.name) row = &k;
  }
  if (row == nullptr) return bad("KIND:COLSxROWS:SIZE_M with chessboard, charuco, aprilgrid or circles as kind");
  if (parts.size() < 2) return bad("its columns and rows are missing: chessboard:9x6:0.025");
  if (parts.size() < 3 || parts[2].empty()) {
    return bad("the size of its squares in metres is missing; no image can show it: measure it");
  }
  if (parts.size() > (row->ratio > 0.0 ? 4U : 3U)) return bad("too many colons: KIND:COLSxROWS:SIZE_M");
  Board board{row->kind, 0, 0, 0.0, row->ratio};
  const std::vector<std::string_view> counts = split(parts[1], 'x');
  if (counts.size() != 2 || !parse_whole(counts[0], board.columns) || !parse_whole(counts[1], board.rows)) {
    return bad("columns and rows are two whole numbers, as in 9x6");
  }
  if (board.columns < row->least || board.rows < row->least || board.columns > kMostCorners ||
      board.rows > kMostCorners || board.corner_count() > kMostCorners) {
    return bad(fmt::format("{} to {} columns and rows", row->least, 100));
  }
  if (!parse_whole(parts[2], board.size_m) || !(board.size_m >= kLeastSize_m && board.size_m <= kMostSize_m)) {
    return bad(fmt::format("the size is in metres, {} to {}: 0.025 for 25 mm", kLeastSize_m, kMostSize_m));
  }
  if (parts.size() == 4 && (!parse_whole(parts[3], board.ratio) || !(board.ratio > 0.0 && board.ratio < 1.0))) {
    return bad("the ratio after the size is above 0 and below 1");
  }
  return board;
}

}  // namespace cliquevo::calibration
