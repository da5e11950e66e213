// gprodom.Outputs: what the estimator found, as arrays and dictionaries.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <functional>
#include <type_traits>

#include "base/text.h"
#include "gprodom/outputs.h"
#include "python/arrays.h"

namespace py = pybind11;
using namespace py::literals;

namespace gprodom {
namespace {

// (n, columns) of a vector or matrix of each estimate.
template <typename Get>
py::array_t<double> table(const std::vector<OdometryEstimate>& estimates, Get get) {
  using Row = std::decay_t<std::invoke_result_t<Get, const OdometryEstimate&>>;
  const auto n = static_cast<py::ssize_t>(estimates.size());
  py::array_t<double> out({n, py::ssize_t{Row::SizeAtCompileTime}});
  for (py::ssize_t k = 0; k < n; ++k)
    Eigen::Map<Row>(out.mutable_data(k, 0)) =
        std::invoke(get, estimates[static_cast<std::size_t>(k)]);
  return out;
}

Eigen::Vector4d wxyz(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

// How much there is, and of which time: what a person asks of an object in a notebook.
std::string summary(const Outputs& outputs) {
  std::string text = "<gprodom.Outputs: " + std::to_string(outputs.odometry.size()) + " odometry";
  if (!outputs.odometry.empty()) {
    text += formatted(" from %.3f to %.3f s", to_seconds(outputs.odometry.front().time),
                      to_seconds(outputs.odometry.back().time));
  }
  const auto count = [&](const char* what, std::size_t number) {
    text += ", " + std::to_string(number) + " " + what;
  };
  count("corrections", outputs.corrections.size());
  count("displacements", outputs.displacements.size());
  count("status", outputs.status.size());
  count("warnings", outputs.warnings.size());
  return text + ">";
}

py::dict to_dict(const Correction& c) {
  return py::dict("time"_a = c.time, "revisits"_a = c.revisits, "position"_a = c.p_map_odom,
                  "orientation"_a = wxyz(c.q_map_odom), "covariance"_a = c.covariance);
}

py::dict to_dict(const Status& s) {
  py::dict values;
  for (size_t k = 0; k < s.names.size(); ++k) values[py::str(s.names[k])] = s.values[k];
  return py::dict("time"_a = s.time, "health"_a = static_cast<int>(s.health),
                  "reasons"_a = s.reasons, "values"_a = values);
}

py::dict to_dict(const Displacement& d) {
  return py::dict("time"_a = d.time, "from"_a = d.from, "to"_a = d.to, "source"_a = d.source,
                  "kind"_a = static_cast<int>(d.kind), "valid"_a = d.valid,
                  "distance"_a = d.distance_m, "sigma"_a = d.sigma_m, "score"_a = d.score,
                  "mirrored"_a = d.mirrored);
}

template <typename Item>
std::vector<py::dict> dicts(const std::vector<Item>& items) {
  std::vector<py::dict> all;
  for (const Item& item : items) all.push_back(to_dict(item));
  return all;
}

}  // namespace

std::map<std::string, py::array> estimate_arrays(const std::vector<OdometryEstimate>& e) {
  using Estimate = OdometryEstimate;
  return {
      {"time", column_of<std::int64_t>(e, [](const Estimate& x) { return x.time; })},
      {"flags", column_of<std::int32_t>(e, [](const Estimate& x) { return x.flags; })},
      {"position", table(e, &Estimate::p_odom_body)},
      {"orientation", table(e, [](const Estimate& x) { return wxyz(x.q_odom_body); })},
      {"velocity", table(e, &Estimate::v_body)},
      {"angular_velocity", table(e, &Estimate::omega_body)},
      {"pose_covariance", table(e, &Estimate::pose_covariance)},
      {"gyro_bias", table(e, &Estimate::gyro_bias)},
      {"accel_bias", table(e, &Estimate::accel_bias)},
      {"wheel_scale", table(e,
                            [](const Estimate& x) {
                              return Eigen::Vector2d(x.wheel_scale, x.wheel_scale_sigma);
                            })},
  };
}

}  // namespace gprodom

void bind_outputs(py::module_& m) {
  using namespace gprodom;
  py::class_<Outputs>(
      m, "Outputs",
      "Results of one step or of a whole run, each list in time order. A path to\n"
      "plot is odometry_map's: odometry is without the corrections of loop closures.")
      .def("__repr__", &summary)
      .def_property_readonly(
          "odometry", [](const Outputs& o) { return estimate_arrays(o.odometry); },
          "Arrays of one row per estimate, in odom: continuous, and without the corrections of\n"
          "loop closures. time (ns), position (m), orientation (w x y z), velocity (m/s) and\n"
          "angular_velocity (rad/s) in body, pose_covariance (n, 36), gyro_bias (rad/s),\n"
          "accel_bias (m/s^2), wheel_scale (value, sigma), flags.")
      .def_property_readonly(
          "odometry_map", [](const Outputs& o) { return estimate_arrays(o.odometry_in_map); },
          "The same poses in map: with the correction of loop closures in effect at that time, so\n"
          "it may jump where one comes into effect. The best path as published.")
      .def_property_readonly(
          "corrections", [](const Outputs& o) { return dicts(o.corrections); },
          "One dict per correction (map to odom), twice a second from the first loop closure on:\n"
          "time (ns), position (3,) m and orientation (w x y z) of odom in map, covariance (6, 6)\n"
          "of the robot's pose in map, revisits.")
      .def_property_readonly(
          "status", [](const Outputs& o) { return dicts(o.status); },
          "One dict per second of data: time, health, reasons, values.")
      .def_property_readonly(
          "displacements", [](const Outputs& o) { return dicts(o.displacements); },
          "One dict per displacement measurement that took effect.")
      .def_readonly("warnings", &Outputs::warnings);
}
