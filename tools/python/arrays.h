// SPDX-License-Identifier: BSD-3-Clause
// numpy arrays and the library's views of the same memory.
#pragma once

#include <pybind11/numpy.h>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/image.h"
#include "core/base/rigid_transform.h"
#include "tools/python/errors.h"

namespace cliquevo::python {

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

// The array's own pixels: 2-D uint8, rows any distance apart, pixels of a row side by side. Anything else is an
// exception that names the argument. Valid while the array is.
ImageView<const std::uint8_t> grey_view(const py::handle& array, const std::string& name);
// The same of a disparity image, int16.
ImageView<const std::int16_t> disparity_view(const py::handle& array, const std::string& name);

// An array of the image's memory, which `owner` keeps alive.
template <typename T>
py::array_t<T> array_of(ImageView<const T> image, const py::object& owner) {
  return py::array_t<T>({static_cast<py::ssize_t>(image.height), static_cast<py::ssize_t>(image.width)},
                        {static_cast<py::ssize_t>(image.stride) * static_cast<py::ssize_t>(sizeof(T)),
                         static_cast<py::ssize_t>(sizeof(T))},
                        image.data, owner);
}
// A new array with a copy of it.
template <typename T>
py::array_t<T> copy_of(ImageView<const T> image) {
  py::array_t<T> out({image.height, image.width});
  for (int y = 0; y < image.height; ++y) std::copy_n(image.row(y), image.width, out.mutable_data(y, 0));
  return out;
}
// A view of a new array's memory.
template <typename T>
ImageView<T> view_of(py::array_t<T>& array) {
  const int width = static_cast<int>(array.shape(1));
  return {array.mutable_data(), width, static_cast<int>(array.shape(0)), width};
}

// 4x4, row by row.
Matrix4 matrix_of(const RigidTransform& T);
// From 4x4 or 3x4 numbers that must be a rigid transform.
RigidTransform transform_of(const py::object& matrix, const std::string& name);
// From an array of N such matrices.
std::vector<RigidTransform> transforms_of(const py::object& matrices, const std::string& name);
py::array_t<double> array_of(const std::vector<RigidTransform>& transforms);

}  // namespace cliquevo::python
