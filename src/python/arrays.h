// Arrays of Python as arguments and results.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

template <class T>
using Array = pybind11::array_t<T, pybind11::array::c_style | pybind11::array::forcecast>;
using Doubles = Array<double>;
using Floats = Array<float>;
using Times = Array<std::int64_t>;  // ns

template <class T>
void require_shape(const Array<T>& array, pybind11::ssize_t dimensions, const char* shape) {
  if (array.ndim() != dimensions)
    throw std::invalid_argument(std::string("expected an array of shape ") + shape);
}

// One value of each of the items.
template <class T, class Items, class Get>
pybind11::array_t<T> column_of(const Items& items, Get get) {
  pybind11::array_t<T> column(static_cast<pybind11::ssize_t>(items.size()));
  T* out = column.mutable_data();
  for (const auto& item : items) *out++ = get(item);
  return column;
}

template <class T, class Items>
pybind11::array_t<T> column_of(const Items& items) {
  return column_of<T>(items, [](const auto& item) { return item; });
}

// One row an estimate, by name; gprodom.Outputs.odometry tells shapes and units.
std::map<std::string, pybind11::array> estimate_arrays(const std::vector<OdometryEstimate>& e);

// A warning of Python for each of the notices.
template <class Notices>
void warn(const Notices& notices) {
  for (const std::string& notice : notices)
    if (PyErr_WarnEx(PyExc_UserWarning, notice.c_str(), 1) != 0)
      throw pybind11::error_already_set();
}

}  // namespace gprodom
