// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "core/odometry/odometry.h"
#include "tools/python/arguments.h"
#include "tools/python/arrays.h"
#include "tools/python/bind.h"
#include "tools/python/py_source.h"

namespace cliquevo::python {

namespace {

using namespace py::literals;
using vo::Estimate;
using vo::Status;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr Status kStatuses[] = {
    Status::no_data,   Status::valid, Status::too_few_features, Status::degenerate, Status::reprojection_error,
    Status::ambiguous, Status::weak};
static_assert(std::size(kStatuses) == static_cast<std::size_t>(Status::weak) + 1);
constexpr const char* kStatusNames[] = {"NO_DATA",   "VALID", "TOO_FEW_FEATURES", "DEGENERATE", "REPROJECTION_ERROR",
                                        "AMBIGUOUS", "WEAK"};

class PyOdometry {
 public:
  PyOdometry(Result<Odometry> odometry) : odometry_(value_of(std::move(odometry))) {}

  Estimate step(const py::object& left, const py::object& right, const py::object& stamp, const py::object& stamp_ns) {
    const TimestampNs at_ns = stamp_of(stamp, stamp_ns);
    const auto left_view = grey_view(left, "left");
    const auto right_view = grey_view(right, "right");
    return value_of(without_gil(mutex_, [&] { return odometry_.step(left_view, right_view, at_ns); }));
  }
  py::array_t<std::int16_t> disparity() {
    py::array_t<std::int16_t> out({odometry_.model().height, odometry_.model().width});
    const ImageView<std::int16_t> to = view_of(out);
    without_gil(mutex_, [&] {
      const auto from = odometry_.disparity();
      for (int y = 0; y < from.height; ++y) std::copy_n(from.row(y), from.width, to.row(y));
    });
    return out;
  }
  void reset() {
    without_gil(mutex_, [&] { odometry_.reset(); });
  }
  const StereoModel& model() const { return odometry_.model(); }

 private:
  std::mutex mutex_;
  Odometry odometry_;
};

OdometryMasks masks_of(const py::object& left_mask, const py::object& right_mask) {
  OdometryMasks out;
  if (!left_mask.is_none()) out.left = grey_view(left_mask, "left_mask");
  if (!right_mask.is_none()) out.right = grey_view(right_mask, "right_mask");
  return out;
}

// A source brings its masks along; those that are given go first.
std::unique_ptr<PyOdometry> make_odometry(const py::object& model, const py::object& left_mask,
                                          const py::object& right_mask, const py::object& settings,
                                          const py::object& config) {
  const daemon::Config read = config_of(settings, config);
  const OdometryParams params{read.stereo, read.odometry, read.rectify};
  OdometryMasks masks = masks_of(left_mask, right_mask);
  if (py::isinstance<StereoModel>(model)) {
    return std::make_unique<PyOdometry>(Odometry::make(model.cast<const StereoModel&>(), params, masks));
  }
  if (py::isinstance<StereoCalibration>(model)) {
    return std::make_unique<PyOdometry>(Odometry::make(model.cast<const StereoCalibration&>(), params, masks));
  }
  if (!py::isinstance<PySource>(model)) {
    raise_type({"unusable model", py::cast<std::string>(py::repr(model)),
                "give a StereoModel, a StereoCalibration or a source"});
  }
  const drivers::SourceInfo& info = model.cast<const PySource&>().info();
  if (masks.left.empty()) masks.left = info.left_mask.cview();
  if (masks.right.empty()) masks.right = info.right_mask.cview();
  return std::make_unique<PyOdometry>(Odometry::make(info.calibration, params, masks));
}

// Ratio of each check that applies: above 1 it failed.
py::dict check_ratios(const Estimate& e) {
  py::dict out;
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const auto check = static_cast<vo::Check>(k);
    if (e.checks[check].applies) out[vo::check_name(check)] = e.checks[check].ratio();
  }
  return out;
}

std::vector<std::string> failed_checks(const Estimate& e) {
  std::vector<std::string> out;
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const auto check = static_cast<vo::Check>(k);
    if (e.checks[check].fails()) out.emplace_back(vo::check_name(check));
  }
  return out;
}

std::string repr_of(const Estimate& e) {
  const Eigen::Vector3d& t = e.T_world_camera.t;
  return std::string("Estimate(") + vo::status_name(e.status) + ", position_m=[" + std::to_string(t.x()) + ", " +
         std::to_string(t.y()) + ", " + std::to_string(t.z()) + "], quality=" + std::to_string(e.quality) + ")";
}

void bind_estimate(py::module_& module) {
  py::enum_<Status> status(module, "Status", "The verdict on a frame.");
  for (std::size_t i = 0; i < std::size(kStatuses); ++i) status.value(kStatusNames[i], kStatuses[i]);
  py::class_<Estimate>(module, "Estimate", "What one step found.")
      .def_readonly("status", &Estimate::status)
      .def_property_readonly("status_name", [](const Estimate& e) { return vo::status_name(e.status); })
      .def_property_readonly("valid", [](const Estimate& e) { return e.status == Status::valid; })
      .def_readonly("stamp_ns", &Estimate::stamp_ns)
      .def_readonly("prev_stamp_ns", &Estimate::prev_stamp_ns)
      .def_property_readonly("T_world_camera", [](const Estimate& e) { return matrix_of(e.T_world_camera); })
      .def_property_readonly("T_prev_cur", [](const Estimate& e) { return matrix_of(e.T_prev_cur); })
      .def_property_readonly("covariance", [](const Estimate& e) { return RowMajor6(e.covariance); })
      .def_readonly("quality", &Estimate::quality)
      .def_readonly("features", &Estimate::features)
      .def_readonly("matches", &Estimate::matches)
      .def_readonly("clique", &Estimate::clique)
      .def_readonly("inliers", &Estimate::inliers)
      .def_readonly("reprojection_error_px", &Estimate::reprojection_error_px)
      .def_readonly("eigenvalue_ratio", &Estimate::eigenvalue_ratio)
      .def_property_readonly("checks", &check_ratios)
      .def_property_readonly("failed_checks", &failed_checks)
      .def_property_readonly("calibration", [](const Estimate& e) { return vo::describe(e.calibration); })
      .def_property_readonly("vehicle_part", [](const Estimate& e) { return vo::describe(e.vehicle_part); })
      .def("__repr__", &repr_of);
}

}  // namespace

void bind_odometry(py::module_& module) {
  bind_estimate(module);
  py::class_<PyOdometry>(module, "Odometry", "Images in, pose, covariance and verdict out.")
      .def(py::init(&make_odometry), "model"_a, py::kw_only(), "left_mask"_a = py::none(), "right_mask"_a = py::none(),
           "settings"_a = py::none(), "config"_a = py::none())
      .def("step", &PyOdometry::step, "left"_a, "right"_a, "stamp"_a = py::none(), py::kw_only(),
           "stamp_ns"_a = py::none(), "One pair, in order of exposure: stamp in seconds or stamp_ns in nanoseconds.")
      .def("reset", &PyOdometry::reset, "Forget all frames and start again at the identity.")
      .def_property_readonly(
          "model", [](const PyOdometry& o) { return o.model(); }, "The rectified pair.")
      .def_property_readonly(
          "disparity", &PyOdometry::disparity,
          "Of the last frame: a copy, int16, px * DISPARITY_SCALE, UNKNOWN_DISPARITY where unknown.");
}

}  // namespace cliquevo::python
