// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pose_row.h"

#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "drivers/text_file.h"

namespace cliquevo::daemon {

std::vector<std::string_view> split_row(std::string_view text, bool keep_empty) {
  constexpr std::string_view kBlank = " \t\r";
  const char between = text.find(';') != std::string_view::npos ? ';' : ',';
  if (!keep_empty || text.find(between) == std::string_view::npos) {
    std::vector<std::string_view> words;
    constexpr std::string_view kBetween = " \t\r,;";
    std::size_t at = text.find_first_not_of(kBetween);
    while (at != std::string_view::npos) {
      const std::size_t end = std::min(text.find_first_of(kBetween, at), text.size());
      words.push_back(text.substr(at, end - at));
      at = text.find_first_not_of(kBetween, end);
    }
    return words;
  }
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(between, at), text.size());
    std::string_view word = text.substr(at, end - at);
    while (!word.empty() && kBlank.find(word.front()) != std::string_view::npos) word.remove_prefix(1);
    while (!word.empty() && kBlank.find(word.back()) != std::string_view::npos) word.remove_suffix(1);
    words.push_back(word);
    at = end + 1;
  }
  return words;
}

std::string shown(std::string_view word) {
  constexpr std::size_t kMost = 32;
  const std::string out = drivers::printable(word.substr(0, kMost));
  return word.size() > kMost ? out + "..." : out;
}

Error bad_row(const PoseRow& row, std::string remedy) {
  return {"cannot read trajectory", fmt::format("{}:{}", row.path, row.line), std::move(remedy)};
}

Result<double> number_in(const PoseRow& row, std::size_t column) {
  if (column >= row.words.size()) return bad_row(row, fmt::format("it has no column {}", column + 1));
  if (const auto value = drivers::parse_number(row.words[column])) return *value;
  return bad_row(row, fmt::format("'{}' is not a number", shown(row.words[column])));
}

Result<RigidTransform> pose_of(const PoseRow& row, const std::array<double, 3>& t, const std::array<double, 4>& q,
                               const char* complaint) {
  const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
  if (!(std::abs(turn.norm() - 1.0) <= 0.01)) return bad_row(row, complaint);
  return RigidTransform{turn.normalized().toRotationMatrix(), {t[0], t[1], t[2]}};
}

Eigen::Matrix3d rotation_of_angles(double roll, double pitch, double yaw) {
  const Eigen::AngleAxisd about_x(roll, Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd about_y(pitch, Eigen::Vector3d::UnitY());
  const Eigen::AngleAxisd about_z(yaw, Eigen::Vector3d::UnitZ());
  return (about_z * about_y * about_x).toRotationMatrix();
}

Eigen::Matrix3d down_to_up() { return Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(); }

}  // namespace cliquevo::daemon
