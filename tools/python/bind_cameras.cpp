// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "core/base/camera_model.h"
#include "drivers/calibration_file.h"
#include "tools/python/arguments.h"
#include "tools/python/arrays.h"
#include "tools/python/bind.h"

namespace cliquevo::python {

namespace {

using namespace py::literals;

constexpr std::pair<const char*, Distortion> kDistortions[] = {
    {"none", Distortion::none},
    {"plumb_bob", Distortion::plumb_bob},
    {"rational", Distortion::rational},
    {"equidistant", Distortion::equidistant},
    {"unified", Distortion::unified},
    {"extended_unified", Distortion::extended_unified},
    {"double_sphere", Distortion::double_sphere},
    {"thin_prism", Distortion::thin_prism},
};

std::string distortion_name(Distortion distortion) {
  for (const auto& [name, value] : kDistortions) {
    if (value == distortion) return name;
  }
  return "none";
}

Distortion distortion_of(const std::string& name) {
  std::string names;
  for (const auto& [known, value] : kDistortions) {
    if (name == known) return value;
    names += (names.empty() ? "" : ", ") + std::string(known);
  }
  raise({"unknown distortion", name, "choose from " + names});
}

StereoModel make_model(int width, int height, double fx_px, double cx_px, double cy_px, double baseline_m,
                       std::optional<double> fy_px, double doffs_px, double readout_s) {
  StereoModel model;
  model.width = width;
  model.height = height;
  model.fx_px = fx_px;
  model.fy_px = fy_px.value_or(fx_px);
  model.cx_px = cx_px;
  model.cy_px = cy_px;
  model.baseline_m = baseline_m;
  model.doffs_px = doffs_px;
  model.readout_s = readout_s;
  check(model.check());
  return model;
}

CameraCalibration make_camera(int width, int height, double fx_px, double fy_px, double cx_px, double cy_px,
                              const std::string& distortion, const std::vector<double>& coefficients) {
  CameraCalibration camera;
  camera.width = width;
  camera.height = height;
  camera.fx_px = fx_px;
  camera.fy_px = fy_px;
  camera.cx_px = cx_px;
  camera.cy_px = cy_px;
  camera.distortion = distortion_of(distortion);
  const std::size_t most =
      camera.coefficients.size() + (camera.distortion == Distortion::thin_prism ? camera.prism.size() : 0);
  if (coefficients.size() > most) {
    raise({"unusable camera", std::to_string(coefficients.size()) + " coefficients of " + distortion,
           "give at most " + std::to_string(most)});
  }
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    (i < 8 ? camera.coefficients[i] : camera.prism[i - 8]) = coefficients[i];
  }
  return camera;
}

StereoCalibration make_calibration(const CameraCalibration& left, const CameraCalibration& right,
                                   const py::object& T_right_left, double readout_s) {
  StereoCalibration out;
  out.left = left;
  out.right = right;
  out.T_right_left = transform_of(T_right_left, "T_right_left");
  out.readout_s = readout_s;
  return out;
}

// m; NaN where the disparity is unknown or not of a point before the camera.
py::array_t<float> depth_m(const StereoModel& model, const py::object& disparity) {
  const ImageView<const std::int16_t> in = disparity_view(disparity, "disparity");
  py::array_t<float> out({in.height, in.width});
  const ImageView<float> to = view_of(out);
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      const double d = in(x, y) / static_cast<double>(kDisparityScale);
      const bool known = in(x, y) != kUnknownDisparity && d + model.doffs_px > 0.0;
      to(x, y) = known ? static_cast<float>(model.depth_m(d)) : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return out;
}

StereoCalibration read_calibration(const py::object& path, int width, int height, bool rectified,
                                   double baseline_unit_m, const std::string& lens, double readout_ms) {
  drivers::CalibrationOptions options;
  options.rectified = rectified;
  options.baseline_unit_m = baseline_unit_m;
  options.lens = lens;
  options.readout_ms = readout_ms;
  check(options.check());
  return value_of(drivers::read_calibration(path_of(path, "path"), width, height, options));
}

std::string repr_of(const StereoModel& m) {
  return "StereoModel(width=" + std::to_string(m.width) + ", height=" + std::to_string(m.height) +
         ", fx_px=" + std::to_string(m.fx_px) + ", baseline_m=" + std::to_string(m.baseline_m) + ")";
}

void bind_model(py::module_& module) {
  py::class_<StereoModel>(module, "StereoModel", "A rectified stereo pair: rows are epipolar lines.")
      .def(py::init(&make_model), py::kw_only(), "width"_a, "height"_a, "fx_px"_a, "cx_px"_a, "cy_px"_a, "baseline_m"_a,
           "fy_px"_a = py::none(), "doffs_px"_a = 0.0, "readout_s"_a = 0.0)
      .def_readonly("width", &StereoModel::width)
      .def_readonly("height", &StereoModel::height)
      .def_readonly("fx_px", &StereoModel::fx_px)
      .def_readonly("fy_px", &StereoModel::fy_px)
      .def_readonly("cx_px", &StereoModel::cx_px)
      .def_readonly("cy_px", &StereoModel::cy_px)
      .def_readonly("baseline_m", &StereoModel::baseline_m)
      .def_readonly("doffs_px", &StereoModel::doffs_px)
      .def_readonly("readout_s", &StereoModel::readout_s)
      .def("depth_m", &depth_m, "disparity"_a, "Depth of each pixel of a disparity image; NaN where it is unknown.")
      .def("__repr__", &repr_of);
}

void bind_camera(py::module_& module) {
  py::class_<CameraCalibration>(module, "Camera", "One camera as it grabs: pinhole and lens.")
      .def(py::init(&make_camera), py::kw_only(), "width"_a, "height"_a, "fx_px"_a, "fy_px"_a, "cx_px"_a, "cy_px"_a,
           "distortion"_a = "none", "coefficients"_a = std::vector<double>())
      .def_readonly("width", &CameraCalibration::width)
      .def_readonly("height", &CameraCalibration::height)
      .def_readonly("fx_px", &CameraCalibration::fx_px)
      .def_readonly("fy_px", &CameraCalibration::fy_px)
      .def_readonly("cx_px", &CameraCalibration::cx_px)
      .def_readonly("cy_px", &CameraCalibration::cy_px)
      .def_property_readonly("distortion", [](const CameraCalibration& c) { return distortion_name(c.distortion); })
      .def_property_readonly("coefficients", [](const CameraCalibration& c) {
        std::vector<double> all(c.coefficients.begin(), c.coefficients.end());
        if (c.distortion == Distortion::thin_prism) all.insert(all.end(), c.prism.begin(), c.prism.end());
        return all;
      });
}

}  // namespace

void bind_cameras(py::module_& module) {
  bind_model(module);
  bind_camera(module);
  py::class_<StereoCalibration>(module, "StereoCalibration",
                                "Two cameras as they grab, and how they sit to each other.")
      .def(py::init(&make_calibration), "left"_a, "right"_a, "T_right_left"_a, py::kw_only(), "readout_s"_a = 0.0)
      .def_readonly("left", &StereoCalibration::left)
      .def_readonly("right", &StereoCalibration::right)
      .def_property_readonly("T_right_left", [](const StereoCalibration& c) { return matrix_of(c.T_right_left); })
      .def_readonly("readout_s", &StereoCalibration::readout_s)
      .def_readonly("rectified", &StereoCalibration::rectified)
      .def_property_readonly("source", [](const StereoCalibration& c) { return text_for_python(c.source); })
      .def_property_readonly("notes", [](const StereoCalibration& c) {
        std::vector<std::string> notes;
        for (const std::string& note : c.notes) notes.push_back(text_for_python(note));
        return notes;
      });
  module.def("read_calibration", &read_calibration, "path"_a, "width"_a = 0, "height"_a = 0, py::kw_only(),
             "rectified"_a = false, "baseline_unit_m"_a = 0.0, "lens"_a = "", "readout_ms"_a = 0.0);
}

}  // namespace cliquevo::python
