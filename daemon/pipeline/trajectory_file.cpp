// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/trajectory_file.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr std::size_t kKittiNumbers = 12;
constexpr std::size_t kTumNumbers = 8;
constexpr std::size_t kKitti360BodyNumbers = 13;  // number of the frame, 3x4 pose of the vehicle's navigation unit
constexpr std::size_t kEurocNumbers = 17;  // ns, position, quaternion (w first), velocity, biases; KITTI-360: see below
constexpr double kMostMetres = 1e8;        // what is further away is no vehicle
constexpr double kMostSeconds = 4.6e9;     // the difference of two stamps must fit into 64 bits of ns

std::string format_seconds(TimestampNs stamp_ns) {
  const bool negative = stamp_ns < 0;
  const std::uint64_t magnitude =
      negative ? ~static_cast<std::uint64_t>(stamp_ns) + 1 : static_cast<std::uint64_t>(stamp_ns);
  return fmt::format("{}{}.{:09}", negative ? "-" : "", magnitude / kNsPerSecond, magnitude % kNsPerSecond);
}

// Seconds as text -> ns without the detour over a double, which holds today's date only to 0.2 µs.
bool parse_seconds(std::string_view text, TimestampNs& stamp_ns) {
  double value = 0.0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failed != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return false;
  if (std::abs(value) >= kMostSeconds) return false;
  const std::size_t point = text.find('.');
  if (text.find_first_of("eE") != std::string_view::npos || point == std::string_view::npos) {
    stamp_ns = std::llround(value * static_cast<double>(kNsPerSecond));
    return true;
  }
  std::int64_t whole = 0;
  const std::string_view before = text.substr(0, point);
  if (!before.empty() && before != "-") std::from_chars(before.data(), before.data() + before.size(), whole);
  std::int64_t fraction = 0;
  std::int64_t unit = kNsPerSecond / 10;
  for (const char c : text.substr(point + 1)) {
    fraction += (c - '0') * unit;
    unit /= 10;
  }
  const bool negative = text.front() == '-';
  stamp_ns = whole * kNsPerSecond + (negative ? -fraction : fraction);
  return true;
}

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBlank = " \t\r,";
  std::size_t at = line.find_first_not_of(kBlank);
  while (at != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlank, end);
  }
  return words;
}

bool parse_number(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), value);
  return failed == std::errc{} && end == word.data() + word.size() && std::isfinite(value);
}

// A word for a message, whatever is in it.
std::string shown(std::string_view word) {
  constexpr std::size_t kMost = 32;
  std::string out(word.substr(0, kMost));
  for (char& c : out) c = c >= 32 && c < 127 ? c : '?';
  return word.size() > kMost ? out + "..." : out;
}

Error bad_line(const std::string& path, int line, std::string remedy) {
  return {"cannot read trajectory", fmt::format("{}:{}", path, line), std::move(remedy)};
}

Result<StampedPose> parse_kitti(const std::vector<std::string_view>& words, const std::string& path, int line) {
  std::array<double, kKittiNumbers> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (!parse_number(words[i], v[i]))
      return bad_line(path, line, fmt::format("'{}' is not a number", shown(words[i])));
  }
  StampedPose pose;
  pose.T_world_camera.R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  pose.T_world_camera.t << v[3], v[7], v[11];
  const Eigen::Matrix3d& R = pose.T_world_camera.R;
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 0.01 || R.determinant() < 0.0) {
    return bad_line(path, line, "columns 1-3, 5-7 and 9-11 must be a rotation matrix");
  }
  return pose;
}

// A place on earth, or as good as.
bool is_near(const Eigen::Vector3d& t) { return t.cwiseAbs().maxCoeff() <= kMostMetres; }

Result<void> parse_all(const std::vector<std::string_view>& words, std::size_t from, const std::string& path, int line,
                       std::vector<double>& out) {
  out.clear();
  for (std::size_t i = from; i < words.size(); ++i) {
    double value = 0.0;
    if (!parse_number(words[i], value))
      return bad_line(path, line, fmt::format("'{}' is not a number", shown(words[i])));
    out.push_back(value);
  }
  return {};
}

// EuRoC: whole nanoseconds, position, quaternion with w first; what follows is not needed.
Result<StampedPose> parse_euroc(const std::vector<std::string_view>& words, const std::string& path, int line) {
  StampedPose pose;
  const std::string_view stamp = words[0];
  const auto [end, failed] = std::from_chars(stamp.data(), stamp.data() + stamp.size(), pose.stamp_ns);
  if (failed != std::errc{} || end != stamp.data() + stamp.size() ||
      std::abs(static_cast<double>(pose.stamp_ns)) > kMostSeconds * kNsPerSecond) {
    return bad_line(path, line, fmt::format("'{}' is not a time in ns", shown(stamp)));
  }
  std::vector<double> v;
  if (auto ok = parse_all({words.begin(), words.begin() + 8}, 1, path, line, v); !ok) return ok.error();
  pose.T_world_camera.t << v[0], v[1], v[2];
  Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
  if (std::abs(q.norm() - 1.0) > 0.01) return bad_line(path, line, "columns 5-8 must be a unit quaternion, w first");
  pose.T_world_camera.R = q.normalized().toRotationMatrix();
  return pose;
}

// KITTI-360: the number of the frame, then the pose as 4x4 (camera) or 3x4 (body) matrix.
Result<StampedPose> parse_kitti360(const std::vector<std::string_view>& words, const std::string& path, int line) {
  const std::string_view number = words[0];
  StampedPose pose;
  const auto [end, failed] = std::from_chars(number.data(), number.data() + number.size(), pose.frame);
  if (failed != std::errc{} || end != number.data() + number.size() || pose.frame < 0) {
    return bad_line(path, line, fmt::format("'{}' is not the number of a frame", shown(number)));
  }
  auto matrix = parse_kitti({words.begin() + 1, words.begin() + 13}, path, line);
  if (!matrix) return matrix;
  pose.T_world_camera = matrix->T_world_camera;
  return pose;
}

enum class RowKind { none, kitti, tum, euroc, kitti360, kitti360_body };

// By the count of numbers; the two kinds with 17 and EuRoC's short one by what is in them.
RowKind kind_of(const std::vector<std::string_view>& words, bool commas) {
  const auto is_ns = [&words] {
    const bool whole = words[0].find_first_not_of("0123456789") == std::string_view::npos;
    return whole && words[0].size() >= 16;
  };
  if (words.size() == kKittiNumbers) return RowKind::kitti;
  if (words.size() == kTumNumbers) return commas && is_ns() ? RowKind::euroc : RowKind::tum;
  if (words.size() == kKitti360BodyNumbers) return RowKind::kitti360_body;
  if (words.size() != kEurocNumbers) return RowKind::none;
  double last = 0.0;
  return !is_ns() && parse_number(words[16], last) && last == 1.0 ? RowKind::kitti360 : RowKind::euroc;
}

Result<StampedPose> parse_tum(const std::vector<std::string_view>& words, const std::string& path, int line) {
  StampedPose pose;
  if (!parse_seconds(words[0], pose.stamp_ns)) {
    return bad_line(path, line, fmt::format("'{}' is not a time in seconds", shown(words[0])));
  }
  std::array<double, kTumNumbers> v{};
  for (std::size_t i = 1; i < v.size(); ++i) {
    if (!parse_number(words[i], v[i]))
      return bad_line(path, line, fmt::format("'{}' is not a number", shown(words[i])));
  }
  pose.T_world_camera.t << v[1], v[2], v[3];
  Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  if (std::abs(q.norm() - 1.0) > 0.01) return bad_line(path, line, "qx qy qz qw must be a unit quaternion");
  pose.T_world_camera.R = q.normalized().toRotationMatrix();
  return pose;
}

Result<StampedPose> parse_row(RowKind kind, const std::vector<std::string_view>& words, const std::string& path,
                              int line) {
  auto pose = kind == RowKind::kitti   ? parse_kitti(words, path, line)
              : kind == RowKind::tum   ? parse_tum(words, path, line)
              : kind == RowKind::euroc ? parse_euroc(words, path, line)
                                       : parse_kitti360(words, path, line);
  if (pose && !is_near(pose->T_world_camera.t)) return bad_line(path, line, "its position is further away than 1e8 m");
  return pose;
}

// A heading without '#'.
bool is_heading(const std::vector<std::string_view>& words) {
  double value = 0.0;
  for (const std::string_view word : words) {
    if (parse_number(word, value)) return false;
  }
  const char c = words.front().front();
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '"';
}

}  // namespace

const char* trajectory_format_name(TrajectoryFormat format) {
  return format == TrajectoryFormat::kitti ? "KITTI" : "TUM";
}

std::string format_pose(TrajectoryFormat format, TimestampNs stamp_ns, const RigidTransform& T_world_camera) {
  const Eigen::Matrix3d& R = T_world_camera.R;
  const Eigen::Vector3d& t = T_world_camera.t;
  std::string out;
  // Adding 0 turns -0 into 0.
  const auto number = [&out](double value) {
    fmt::format_to(std::back_inserter(out), "{}{:.12e}", out.empty() ? "" : " ", value + 0.0);
  };
  if (format == TrajectoryFormat::kitti) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) number(R(row, column));
      number(t(row));
    }
    return out;
  }
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  out = format_seconds(stamp_ns);
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) number(value);
  return out;
}

void TrajectoryWriter::Close::operator()(std::FILE* file) const { std::fclose(file); }

Result<TrajectoryWriter> TrajectoryWriter::open(const std::string& path, TrajectoryFormat format) {
  TrajectoryWriter writer;
  writer.path_ = path;
  writer.format_ = format;
  writer.file_.reset(std::fopen(path.c_str(), "w"));
  if (!writer.file_) {
    return Error{"cannot write trajectory", path,
                 fmt::format("{}; name a file that can be created", std::strerror(errno))};
  }
  return writer;
}

Result<void> TrajectoryWriter::append(TimestampNs stamp_ns, const RigidTransform& T_world_camera) {
  const std::string line = format_pose(format_, stamp_ns, T_world_camera) + "\n";
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size() || std::fflush(file_.get()) != 0) {
    return Error{"cannot write trajectory", path_, fmt::format("{}; make room on the disk", std::strerror(errno))};
  }
  return {};
}

Result<Trajectory> read_trajectory(const std::string& path) {
  std::ifstream in(path);
  if (!in) {
    return Error{"cannot read trajectory", path,
                 fmt::format("{}; name a KITTI or TUM trajectory file", std::strerror(errno))};
  }
  Trajectory out;
  std::string text;
  RowKind kind = RowKind::none;
  std::size_t numbers_a_line = 0;
  for (int line = 1; std::getline(in, text); ++line) {
    const std::vector<std::string_view> words = split_words(text);
    if (words.empty() || words.front().front() == '#') continue;
    if (line == 1 && is_heading(words)) continue;
    const RowKind here = kind_of(words, text.find(',') != std::string::npos);
    if (here == RowKind::none) {
      return bad_line(path, line,
                      fmt::format("{} words where a pose has 12 numbers (KITTI), 8 (TUM) or 17 (EuRoC, KITTI-360's "
                                  "cam0_to_world.txt; 13 in its poses.txt)",
                                  words.size()));
    }
    if (kind == RowKind::none) kind = here;
    if (numbers_a_line == 0) numbers_a_line = words.size();
    if (words.size() != numbers_a_line) {
      return bad_line(path, line, fmt::format("{} numbers after lines of {}", words.size(), numbers_a_line));
    }
    if (here != kind) return bad_line(path, line, "it is of another format than the lines before");
    Result<StampedPose> pose = parse_row(kind, words, path, line);
    if (!pose) return pose.error();
    if (!out.poses.empty()) {
      const StampedPose& last = out.poses.back();
      if (pose->stamp_ns < last.stamp_ns) return bad_line(path, line, "times must not fall: sort the file by time");
      if (pose->frame >= 0 && pose->frame <= last.frame) {
        return bad_line(path, line, "frames must rise: sort the file");
      }
    }
    out.poses.push_back(*pose);
  }
  out.format = kind == RowKind::tum || kind == RowKind::euroc ? TrajectoryFormat::tum : TrajectoryFormat::kitti;
  out.numbered = kind == RowKind::kitti360 || kind == RowKind::kitti360_body;
  out.of_body = kind == RowKind::euroc || kind == RowKind::kitti360_body;
  if (in.bad()) return Error{"cannot read trajectory", path, "is it a file?"};
  if (out.poses.empty()) return Error{"cannot read trajectory", path, "the file holds no pose"};
  return out;
}

}  // namespace cliquevo::daemon
