// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"
#include "tools/python/arguments.h"
#include "tools/python/arrays.h"
#include "tools/python/bind.h"

namespace cliquevo::python {

namespace {

using namespace py::literals;

class PyDenseStereo {
 public:
  PyDenseStereo(int width, int height, const py::object& settings, const py::object& config)
      : stereo_(value_of(stereo::DenseStereo::make(config_of(settings, config).stereo, width, height))),
        filtered_(width, height) {}

  py::array_t<std::int16_t> compute(const py::object& left, const py::object& right) {
    const auto left_view = grey_view(left, "left");
    const auto right_view = grey_view(right, "right");
    py::array_t<std::int16_t> out({filtered_.height(), filtered_.width()});
    const ImageView<std::int16_t> to = view_of(out);
    check(without_gil(mutex_, [&] { return stereo_.compute(left_view, right_view, filtered_.view(), to); }));
    return out;
  }

 private:
  std::mutex mutex_;
  stereo::DenseStereo stereo_;
  Image<std::uint8_t> filtered_;
};

class PyRectifier {
 public:
  PyRectifier(const StereoCalibration& calibration, const py::object& settings, const py::object& config)
      : rectifier_(value_of(stereo::Rectifier::make(calibration, config_of(settings, config).rectify))) {}

  py::tuple rectify(const py::object& left, const py::object& right) {
    const auto left_view = grey_view(left, "left");
    const auto right_view = grey_view(right, "right");
    const StereoModel& model = rectifier_.model();
    py::array_t<std::uint8_t> left_out({model.height, model.width});
    py::array_t<std::uint8_t> right_out({model.height, model.width});
    const ImageView<std::uint8_t> left_to = view_of(left_out);
    const ImageView<std::uint8_t> right_to = view_of(right_out);
    check(without_gil(mutex_, [&]() -> Result<void> {
      if (auto ok = rectifier_.rectify(stereo::CameraSide::left, left_view, left_to); !ok) return ok;
      return rectifier_.rectify(stereo::CameraSide::right, right_view, right_to);
    }));
    return py::make_tuple(left_out, right_out);
  }
  const StereoModel& model() const { return rectifier_.model(); }

 private:
  std::mutex mutex_;
  stereo::Rectifier rectifier_;
};

}  // namespace

void bind_stereo(py::module_& module) {
  module.attr("UNKNOWN_DISPARITY") = kUnknownDisparity;
  module.attr("DISPARITY_SCALE") = kDisparityScale;
  py::class_<PyRectifier>(module, "Rectifier", "Images as grabbed to images whose rows are epipolar lines.")
      .def(py::init<const StereoCalibration&, const py::object&, const py::object&>(), "calibration"_a, py::kw_only(),
           "settings"_a = py::none(), "config"_a = py::none())
      .def("rectify", &PyRectifier::rectify, "left"_a, "right"_a, "The rectified pair as two new arrays.")
      .def_property_readonly("model", [](const PyRectifier& r) { return r.model(); });
  py::class_<PyDenseStereo>(module, "DenseStereo", "Disparity of rectified pairs.")
      .def(py::init<int, int, const py::object&, const py::object&>(), "width"_a, "height"_a, py::kw_only(),
           "settings"_a = py::none(), "config"_a = py::none())
      .def("compute", &PyDenseStereo::compute, "left"_a, "right"_a,
           "int16, px * DISPARITY_SCALE of the left image; UNKNOWN_DISPARITY where there is none.");
}

}  // namespace cliquevo::python
