// SPDX-License-Identifier: BSD-3-Clause
// Reads trajectory files of every format: recognised once, then each row is read so.
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "daemon/pipeline/pose_heading.h"
#include "daemon/pipeline/pose_kinds.h"
#include "daemon/pipeline/pose_stamps.h"
#include "daemon/pipeline/trajectory_file.h"
#include "drivers/text_file.h"

namespace cliquevo::daemon {

namespace {

constexpr double kMostMetres = 1e8;  // what is further away is no vehicle

struct TextRow {
  std::string_view text;
  int line = 0;
};

struct FileText {
  std::vector<TextRow> headings;  // comments before the first row, and a first line without numbers
  bool bare = false;              // the last of them is no comment
  std::vector<TextRow> rows;
};

// A heading without '#'.
bool is_heading(std::string_view text) {
  const auto words = split_row(text, false);
  const auto is_number = [](std::string_view word) { return drivers::parse_number(word).has_value(); };
  if (std::any_of(words.begin(), words.end(), is_number)) return false;
  const char c = words.front().front();
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '"' || c == '_';
}

// Semicolons leave commas to stand for points.
void part(std::string& text, FileText& out) {
  int line = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view whole(text.data() + at, end - at);
    const std::size_t first = whole.find_first_not_of(" \t\r,;");
    ++line;
    const std::size_t begin = std::exchange(at, end + 1);
    if (first == std::string_view::npos) continue;
    if (whole[first] == '#' || whole[first] == '%') {
      const std::size_t name = std::min(whole.find_first_not_of("#% \t", first), whole.size());
      if (out.rows.empty() && !out.bare) out.headings.push_back({whole.substr(name), line});
      out.bare = out.bare || (out.rows.empty() && whole[first] == '%' && name == first + 1);  // "%time,...": rostopic
      continue;
    }
    if (out.rows.empty() && !out.bare && is_heading(whole)) {
      out.headings.push_back({whole, line});
      out.bare = true;
      continue;
    }
    if (whole.find(';') != std::string_view::npos)
      std::replace(text.begin() + static_cast<std::ptrdiff_t>(begin), text.begin() + static_cast<std::ptrdiff_t>(end),
                   ',', '.');
    out.rows.push_back({whole, line});
  }
}

PoseRow row_of(const TextRow& row, const std::string& path, bool keep_empty) {
  return {split_row(row.text, keep_empty), row.text.find(',') != std::string_view::npos, path, row.line};
}

// How the rows of a file are read.
struct Choice {
  RowReader reader;
  const PoseKind* kind = nullptr;  // by the count of words
  std::size_t columns = 0;         // by a heading
};

Error no_kind(const PoseRow& row) {
  return bad_row(row, fmt::format("{} words where a pose has {}; a first line that names the columns says more "
                                  "(timestamp x y z qx qy qz qw)",
                                  row.words.size(), known_pose_kinds()));
}

Result<Choice> choose(const FileText& file, const std::string& path) {
  Choice out;
  const PoseRow first = row_of(file.rows.front(), path, true);
  const PoseRow words = row_of(file.rows.front(), path, false);
  out.kind = pose_kind_of(words);
  for (std::size_t i = file.headings.size(); i-- > 0;) {
    const bool bare = file.bare && i + 1 == file.headings.size();
    auto heading = read_pose_heading(file.headings[i].text, bare, first);
    if (!heading) return heading.error();
    if (!*heading) continue;
    // The formats of the same columns say whose poses they are.
    const RowReader* alike = out.kind != nullptr && (*heading)->w_first ? &out.kind->reader : nullptr;
    out.kind = nullptr;
    out.columns = (*heading)->columns;
    out.reader = std::move((*heading)->reader);
    if (alike != nullptr && alike->body != nullptr && out.reader.body == nullptr) {
      out.reader.body = alike->body;
      out.reader.mounting = alike->mounting;
    }
    return out;
  }
  if (out.kind == nullptr) return no_kind(words);
  out.reader = out.kind->reader;
  return out;
}

// All rows as words, alike.
Result<std::vector<PoseRow>> words_of(const FileText& file, const Choice& choice, const std::string& path) {
  std::vector<PoseRow> rows;
  rows.reserve(file.rows.size());
  for (const TextRow& text : file.rows) {
    PoseRow row = row_of(text, path, choice.columns > 0);
    while (choice.columns > 0 && row.words.size() > choice.columns && row.words.back().empty()) row.words.pop_back();
    if (choice.columns > 0 && row.words.size() != choice.columns) {
      return bad_row(row, fmt::format("{} words where the heading names {} columns", row.words.size(), choice.columns));
    }
    if (!rows.empty() && row.words.size() != rows.front().words.size()) {
      return bad_row(row, fmt::format("{} numbers after lines of {}", row.words.size(), rows.front().words.size()));
    }
    if (choice.kind != nullptr && pose_kind_of(row) != choice.kind)
      return bad_row(row, "it is of another format than the lines before");
    rows.push_back(std::move(row));
  }
  return rows;
}

// What the first row's own words decide.
void settle(const PoseRow& first, RowReader& reader) {
  if (reader.child_frame && reader.body == nullptr &&
      first.words[*reader.child_frame].find("optical") == std::string_view::npos) {
    reader.body = "the vehicle (nav_msgs/Odometry)";
  }
  if (!reader.frame) return;
  const auto number = drivers::parse_integer(first.words[*reader.frame]);
  if (!number) reader.frame.reset();  // names: a row a frame
  // 4Seasons' frame_id is a time.
  if (number && *number >= 100'000'000'000) reader.stamp = std::exchange(reader.frame, std::nullopt);
}

Result<std::int64_t> frame_of(const PoseRow& row, std::size_t column) {
  const auto number = drivers::parse_integer(row.words[column]);
  if (number && *number >= 0) return *number;
  return bad_row(row, fmt::format("'{}' is not the number of a frame", shown(row.words[column])));
}

Result<StampedPose> read_pose(const PoseRow& row, const RowReader& reader, bool stamps_known) {
  StampedPose pose;
  if (reader.stamp && !stamps_known) {
    const auto stamp = stamp_of(row, reader);
    if (!stamp) return stamp.error();
    pose.stamp_ns = *stamp;
  }
  if (reader.frame) {
    const auto frame = frame_of(row, *reader.frame);
    if (!frame) return frame.error();
    pose.frame = *frame;
  }
  const auto T = reader.pose(row);
  if (!T) return T.error();
  if (!(T->t.cwiseAbs().maxCoeff() <= kMostMetres)) return bad_row(row, "its position is further away than 1e8 m");
  pose.T_world_camera = *T;
  return pose;
}

Result<void> read_poses(const std::vector<PoseRow>& rows, const RowReader& reader, Trajectory& out) {
  const auto spaced = reader.stamp ? stamps_by_spacing(rows, reader) : std::nullopt;
  if (spaced) out.note = spaced->note;
  for (const PoseRow& row : rows) {
    auto pose = read_pose(row, reader, spaced.has_value());
    if (!pose) return pose.error();
    if (spaced) pose->stamp_ns = spaced->stamps_ns[out.poses.size()];
    if (!out.poses.empty()) {
      const StampedPose& last = out.poses.back();
      if (pose->stamp_ns < last.stamp_ns) return bad_row(row, "times must not fall: sort the file by time");
      if (pose->frame >= 0 && pose->frame <= last.frame) return bad_row(row, "frames must rise: sort the file");
    }
    out.poses.push_back(*pose);
  }
  return {};
}

}  // namespace

Result<Trajectory> read_trajectory(const std::string& path) {
  std::ifstream in(path);
  if (!in) {
    return Error{"cannot read trajectory", path,
                 fmt::format("{}; name a KITTI or TUM trajectory file", std::strerror(errno))};
  }
  std::string text;
  for (std::string line; std::getline(in, line);) text.append(line).push_back('\n');
  if (in.bad()) return Error{"cannot read trajectory", path, "is it a file?"};
  text = drivers::utf8_of(std::move(text));
  if (text.compare(0, 3, "\xEF\xBB\xBF") == 0) text.erase(0, 3);
  FileText file;
  part(text, file);
  if (file.rows.empty()) return Error{"cannot read trajectory", path, "the file holds no pose"};
  auto choice = choose(file, path);
  if (!choice) return choice.error();
  const auto rows = words_of(file, *choice, path);
  if (!rows) return rows.error();
  RowReader& reader = choice->reader;
  settle(rows->front(), reader);
  Trajectory out;
  if (const auto ok = read_poses(*rows, reader, out); !ok) return ok.error();
  out.format = reader.stamp ? TrajectoryFormat::tum : TrajectoryFormat::kitti;
  out.numbered = reader.frame.has_value();
  out.of_body = reader.body != nullptr;
  out.body = out.of_body ? reader.body : "";
  out.mounting = reader.mounting;
  if (out.note.empty() && reader.note != nullptr) out.note = reader.note;
  return out;
}

}  // namespace cliquevo::daemon
