// SPDX-License-Identifier: BSD-3-Clause
// Trajectory files, and how far one is from its reference.
#include <cmath>
#include <pybind11/stl.h>

#include "daemon/pipeline/trajectory_file.h"
#include "tools/evaluation.h"
#include "tools/evaluation_json.h"
#include "tools/python/arguments.h"
#include "tools/python/arrays.h"
#include "tools/python/bind.h"
#include "tools/reference.h"

namespace cliquevo::python {

namespace {

using namespace py::literals;
using daemon::Trajectory;
using daemon::TrajectoryFormat;

TrajectoryFormat format_of(const std::string& name) {
  if (name == "kitti") return TrajectoryFormat::kitti;
  if (name == "tum") return TrajectoryFormat::tum;
  raise({"unknown trajectory format", name, "choose from kitti, tum"});
}

// (stamps in ns or None, poses).
py::tuple read_trajectory(const py::object& path) {
  const Trajectory read = value_of(daemon::read_trajectory(path_of(path, "path")));
  std::vector<RigidTransform> poses;
  py::array_t<std::int64_t> stamps(static_cast<py::ssize_t>(read.poses.size()));
  for (std::size_t i = 0; i < read.poses.size(); ++i) {
    poses.push_back(read.poses[i].T_world_camera);
    stamps.mutable_at(static_cast<py::ssize_t>(i)) = read.poses[i].stamp_ns;
  }
  const bool stamped = read.format == TrajectoryFormat::tum;
  return py::make_tuple(stamped ? py::object(stamps) : py::object(py::none()), array_of(poses));
}

void write_trajectory(const py::object& path, const py::object& poses,
                      const std::optional<std::vector<std::int64_t>>& stamps_ns, const std::string& format_name) {
  const TrajectoryFormat format = format_of(format_name);
  const std::vector<RigidTransform> transforms = transforms_of(poses, "poses");
  if (format == TrajectoryFormat::tum && !stamps_ns) {
    raise_type({"cannot write a trajectory", "stamps_ns is None", "TUM files carry stamps: give one a pose"});
  }
  if (stamps_ns && stamps_ns->size() != transforms.size()) {
    raise({"cannot write a trajectory",
           std::to_string(stamps_ns->size()) + " stamps, " + std::to_string(transforms.size()) + " poses",
           "give one stamp a pose"});
  }
  auto writer = value_of(daemon::TrajectoryWriter::open(path_of(path, "path"), format));
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    check(writer.append(stamps_ns ? (*stamps_ns)[i] : 0, transforms[i]));
  }
}

Trajectory trajectory_of(const py::object& given, const std::string& name) {
  Trajectory out;
  for (const RigidTransform& T : transforms_of(given, name)) out.poses.push_back({0, T});
  return out;
}

tools::EvaluationOptions options_of(const std::optional<std::vector<double>>& lengths_m, double tolerance_s,
                                    double sample_period_s, const std::string& reference_frame) {
  tools::EvaluationOptions options;
  if (lengths_m) options.lengths_m = *lengths_m;
  for (const double length : options.lengths_m) {
    if (!(length > 0.0 && length <= 1e9)) {
      raise({"unusable length", std::to_string(length), "give lengths of segments in m, above 0"});
    }
  }
  if (!(tolerance_s >= 0.0 && tolerance_s <= 1e6)) {
    raise({"unusable tolerance", std::to_string(tolerance_s), "give a time from 0 to 1000000 s"});
  }
  if (!(sample_period_s >= 0.0 && sample_period_s <= 1e9)) {
    raise({"unusable sample period", std::to_string(sample_period_s), "give a time in s, 0 for none"});
  }
  if (reference_frame != "camera" && reference_frame != "body") {
    raise({"unknown reference frame", reference_frame, "choose from camera, body"});
  }
  options.max_stamp_difference_ns = static_cast<std::int64_t>(tolerance_s * 1e9);
  options.sample_period_s = sample_period_s;
  options.reference_frame = reference_frame == "body" ? tools::ReferenceFrame::body : tools::ReferenceFrame::camera;
  return options;
}

py::object evaluate(const py::object& reference, const py::object& estimate,
                    const std::optional<std::vector<double>>& lengths_m, double tolerance_s, double sample_period_s,
                    const std::string& reference_frame) {
  const tools::EvaluationOptions options = options_of(lengths_m, tolerance_s, sample_period_s, reference_frame);
  tools::ReferenceAndEstimate compared;
  if (is_path(reference) && is_path(estimate)) {
    compared = value_of(tools::read_compared(path_of(reference, "reference"), path_of(estimate, "estimate"),
                                             reference_frame == "body"));
  } else {
    compared.reference = is_path(reference) ? value_of(tools::read_reference(path_of(reference, "reference")))
                                            : trajectory_of(reference, "reference");
    compared.estimate = is_path(estimate) ? value_of(daemon::read_trajectory(path_of(estimate, "estimate")))
                                          : trajectory_of(estimate, "estimate");
  }
  const Trajectory& truth = compared.reference;
  const Trajectory& judged = compared.estimate;
  std::mutex alone;
  const auto result = value_of(without_gil(alone, [&]() -> Result<tools::Evaluation> {
    const auto pairs = tools::associate(truth, judged, options);
    if (!pairs) return pairs.error();
    tools::Evaluation out = tools::evaluate(*pairs, options);
    out.frames_reference = truth.poses.size();
    out.frames_estimate = judged.poses.size();
    return out;
  }));
  return py::module_::import("json").attr("loads")(tools::evaluation_json(result));
}

}  // namespace

void bind_trajectory(py::module_& module) {
  module.def("read_trajectory", &read_trajectory, "path"_a);
  module.def("write_trajectory", &write_trajectory, "path"_a, "poses"_a, "stamps_ns"_a = py::none(), py::kw_only(),
             "format"_a = "kitti");
  module.def("evaluate", &evaluate, "reference"_a, "estimate"_a, py::kw_only(), "lengths_m"_a = py::none(),
             "tolerance_s"_a = 0.01, "sample_period_s"_a = 0.0, "reference_frame"_a = "camera");
}

}  // namespace cliquevo::python
