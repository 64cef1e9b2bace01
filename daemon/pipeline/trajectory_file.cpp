// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/trajectory_file.h"

#include <cerrno>
#include <cstring>
#include <iterator>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

std::string format_seconds(TimestampNs stamp_ns) {
  const bool negative = stamp_ns < 0;
  const std::uint64_t magnitude =
      negative ? ~static_cast<std::uint64_t>(stamp_ns) + 1 : static_cast<std::uint64_t>(stamp_ns);
  return fmt::format("{}{}.{:09}", negative ? "-" : "", magnitude / kNsPerSecond, magnitude % kNsPerSecond);
}

}  // namespace

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

}  // namespace cliquevo::daemon
