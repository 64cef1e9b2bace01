// SPDX-License-Identifier: BSD-3-Clause
#include "tools/python/arrays.h"

#include <cmath>

#include <Eigen/LU>

namespace cliquevo::python {

namespace {

constexpr py::ssize_t kMostPixels = 16384;  // each way

std::string text_of(const py::handle& object) { return py::cast<std::string>(py::str(object)); }

std::string kind_of(const py::handle& object) { return Py_TYPE(object.ptr())->tp_name; }

template <typename T>
ImageView<const T> image_view(const py::handle& object, const std::string& name, const std::string& wanted) {
  const auto wrong = [&](const std::string& where, const std::string& remedy) {
    return Error{"unusable image", name + " " + where, remedy};
  };
  if (object.is_none()) raise_type(wrong("is None", "give a 2-D numpy array of " + wanted));
  if (!py::isinstance<py::array>(object)) {
    raise_type(wrong("is of type " + kind_of(object), "give a numpy array: numpy.asarray(" + name + ")"));
  }
  const auto array = py::reinterpret_borrow<py::array>(object);
  if (!array.dtype().equal(py::dtype::of<T>())) {
    raise_type(wrong("has dtype " + text_of(array.dtype()), "give " + wanted + ": scale the values yourself"));
  }
  const std::string shape = "has shape " + text_of(array.attr("shape"));
  if (array.ndim() != 2) raise(wrong(shape, "give one grey image of shape (height, width)"));
  const py::ssize_t height = array.shape(0);
  const py::ssize_t width = array.shape(1);
  if (height < 1 || width < 1 || height > kMostPixels || width > kMostPixels) {
    raise(wrong(shape, "give 1 to " + std::to_string(kMostPixels) + " pixels each way"));
  }
  constexpr auto kSize = static_cast<py::ssize_t>(sizeof(T));
  const py::ssize_t step = width > 1 ? array.strides(1) : kSize;
  const py::ssize_t row = height > 1 ? array.strides(0) : width * kSize;
  const bool aligned = reinterpret_cast<std::uintptr_t>(array.data()) % sizeof(T) == 0;
  if (step != kSize || row < width * kSize || row % kSize != 0 || !aligned) {
    raise(wrong("has strides " + text_of(array.attr("strides")),
                "the pixels of a row must lie side by side, and rows in order: numpy.ascontiguousarray(" + name + ")"));
  }
  return {static_cast<const T*>(array.data()), static_cast<int>(width), static_cast<int>(height), row / kSize};
}

// A double array of at least so many dimensions, whatever holds the numbers.
py::array_t<double> numbers_of(const py::object& object, const std::string& name, const std::string& remedy) {
  if (object.is_none()) raise_type({"unusable poses", name + " is None", remedy});
  auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(object);
  if (!numbers) {
    PyErr_Clear();
    raise_type({"unusable poses", name + " is of type " + kind_of(object), remedy});
  }
  return numbers;
}

RigidTransform rigid(const double* rows, const std::string& name) {
  RigidTransform T;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) T.R(i, j) = rows[4 * i + j];
    T.t(i) = rows[4 * i + 3];
  }
  // Files carry rotations to some seven digits.
  const bool rotation =
      T.is_finite() && (T.R * T.R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3 && T.R.determinant() > 0.0;
  if (!rotation) raise({"unusable pose", name, "give [R t] with a rotation matrix R and finite numbers"});
  return T;
}

}  // namespace

ImageView<const std::uint8_t> grey_view(const py::handle& array, const std::string& name) {
  return image_view<std::uint8_t>(array, name, "uint8");
}

ImageView<const std::int16_t> disparity_view(const py::handle& array, const std::string& name) {
  return image_view<std::int16_t>(array, name, "int16");
}

Matrix4 matrix_of(const RigidTransform& T) {
  Matrix4 out = Matrix4::Identity();
  out.topLeftCorner<3, 3>() = T.R;
  out.topRightCorner<3, 1>() = T.t;
  return out;
}

RigidTransform transform_of(const py::object& matrix, const std::string& name) {
  const std::string remedy = "give a 4x4 or 3x4 matrix";
  const auto numbers = numbers_of(matrix, name, remedy);
  if (numbers.ndim() != 2 || numbers.shape(1) != 4 || (numbers.shape(0) != 4 && numbers.shape(0) != 3)) {
    raise({"unusable pose", name + " has shape " + text_of(numbers.attr("shape")), remedy});
  }
  return rigid(numbers.data(), name);
}

std::vector<RigidTransform> transforms_of(const py::object& matrices, const std::string& name) {
  const std::string remedy = "give an array of shape (N, 4, 4) or (N, 3, 4)";
  const auto numbers = numbers_of(matrices, name, remedy);
  if (numbers.ndim() != 3 || numbers.shape(2) != 4 || (numbers.shape(1) != 4 && numbers.shape(1) != 3)) {
    raise({"unusable poses", name + " has shape " + text_of(numbers.attr("shape")), remedy});
  }
  std::vector<RigidTransform> out;
  out.reserve(static_cast<std::size_t>(numbers.shape(0)));
  for (py::ssize_t i = 0; i < numbers.shape(0); ++i) {
    out.push_back(rigid(numbers.data(i, 0, 0), name + "[" + std::to_string(i) + "]"));
  }
  return out;
}

py::array_t<double> array_of(const std::vector<RigidTransform>& transforms) {
  py::array_t<double> out({static_cast<py::ssize_t>(transforms.size()), py::ssize_t{4}, py::ssize_t{4}});
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    const Matrix4 T = matrix_of(transforms[i]);
    std::copy_n(T.data(), 16, out.mutable_data(static_cast<py::ssize_t>(i), 0, 0));
  }
  return out;
}

}  // namespace cliquevo::python
