// Estimates as arrays for Python.
#pragma once

#include <pybind11/numpy.h>

#include <map>
#include <string>
#include <vector>

#include "gprodom/types.h"

// One row an estimate, by name; gprodom.Outputs.odometry tells shapes and units.
namespace gprodom {
std::map<std::string, pybind11::array> estimate_arrays(const std::vector<OdometryEstimate>& e);
}
