// gprodom.Outputs: what the estimator found, as arrays and dictionaries.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstdio>

#include "gprodom/outputs.h"
#include "python/python_outputs.h"

namespace py = pybind11;

namespace gprodom {
namespace {

using Rows = py::array_t<double>;

// (n, columns) of what `row` writes for each estimate.
template <typename Row>
Rows table(const std::vector<OdometryEstimate>& estimates, py::ssize_t columns, Row row) {
  Rows out({static_cast<py::ssize_t>(estimates.size()), columns});
  for (size_t k = 0; k < estimates.size(); ++k)
    row(estimates[k], out.mutable_data(static_cast<py::ssize_t>(k), 0));
  return out;
}

// How much there is, and of which time: what a person asks of an object in a notebook.
std::string summary(const Outputs& outputs) {
  std::string text = "<gprodom.Outputs: " + std::to_string(outputs.odometry.size()) + " odometry";
  if (!outputs.odometry.empty()) {
    char times[80];
    std::snprintf(times, sizeof times, " from %.3f to %.3f s",
                  to_seconds(outputs.odometry.front().time),
                  to_seconds(outputs.odometry.back().time));
    text += times;
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

py::dict to_dict(const Status& s) {
  py::dict values;
  for (size_t k = 0; k < s.names.size(); ++k) values[py::str(s.names[k])] = s.values[k];
  py::dict d;
  d["time"] = s.time;
  d["health"] = static_cast<int>(s.health);
  d["reasons"] = s.reasons;
  d["values"] = values;
  return d;
}

}  // namespace

std::map<std::string, py::array> estimate_arrays(const std::vector<OdometryEstimate>& e) {
  const auto copy = [](const auto& m, double* to) {
    for (Eigen::Index k = 0; k < m.size(); ++k) to[k] = m.data()[k];
  };
  py::array_t<std::int64_t> time(static_cast<py::ssize_t>(e.size()));
  py::array_t<std::int32_t> flags(static_cast<py::ssize_t>(e.size()));
  for (size_t k = 0; k < e.size(); ++k) {
    time.mutable_at(k) = e[k].time;
    flags.mutable_at(k) = e[k].flags;
  }
  std::map<std::string, py::array> d;
  d["time"] = time;
  d["flags"] = flags;
  d["position"] = table(e, 3, [&](const auto& x, double* to) { copy(x.p_odom_body, to); });
  d["orientation"] = table(e, 4, [](const auto& x, double* to) {
    to[0] = x.q_odom_body.w(), to[1] = x.q_odom_body.x(), to[2] = x.q_odom_body.y(),
    to[3] = x.q_odom_body.z();
  });
  d["velocity"] = table(e, 3, [&](const auto& x, double* to) { copy(x.v_body, to); });
  d["angular_velocity"] = table(e, 3, [&](const auto& x, double* to) { copy(x.omega_body, to); });
  d["pose_covariance"] =
      table(e, 36, [&](const auto& x, double* to) { copy(x.pose_covariance, to); });
  d["gyro_bias"] = table(e, 3, [&](const auto& x, double* to) { copy(x.gyro_bias, to); });
  d["accel_bias"] = table(e, 3, [&](const auto& x, double* to) { copy(x.accel_bias, to); });
  d["wheel_scale"] = table(
      e, 2, [](const auto& x, double* to) { to[0] = x.wheel_scale, to[1] = x.wheel_scale_sigma; });
  return d;
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
          "Arrays of one row per estimate, in odom: continuous, and without the corrections of "
          "loop\n"
          "closures. time (ns), position (m), orientation (w x y z), velocity (m/s) and\n"
          "angular_velocity (rad/s) in body, pose_covariance (n, 36), gyro_bias (rad/s), "
          "accel_bias\n"
          "(m/s^2), wheel_scale (value, sigma), flags.")
      .def_property_readonly(
          "odometry_map", [](const Outputs& o) { return estimate_arrays(o.odometry_in_map); },
          "The same poses in map: with the correction of loop closures in effect at that time, so "
          "it\n"
          "may jump where one comes into effect. The best path as published.")
      .def_property_readonly(
          "corrections",
          [](const Outputs& o) {
            std::vector<py::dict> l;
            for (const auto& x : o.corrections) {
              py::dict d;
              d["time"] = x.time, d["revisits"] = x.revisits, d["position"] = x.p_map_odom;
              d["orientation"] = Eigen::Vector4d(x.q_map_odom.w(), x.q_map_odom.x(),
                                                 x.q_map_odom.y(), x.q_map_odom.z());
              d["covariance"] = x.covariance;
              l.push_back(d);
            }
            return l;
          },
          "One dict per correction (map to odom), twice a second from the first loop closure on: "
          "time\n"
          "(ns), position (3,) m and orientation (w x y z) of odom in map, covariance (6, 6) of "
          "the\n"
          "robot's pose in map, revisits.")
      .def_property_readonly(
          "status",
          [](const Outputs& o) {
            std::vector<py::dict> l;
            for (const auto& s : o.status) l.push_back(to_dict(s));
            return l;
          },
          "One dict per second of data: time, health, reasons, values.")
      .def_property_readonly(
          "displacements",
          [](const Outputs& o) {
            std::vector<py::dict> l;
            for (const auto& x : o.displacements) {
              py::dict d;
              d["time"] = x.time, d["from"] = x.from, d["to"] = x.to, d["source"] = x.source;
              d["kind"] = static_cast<int>(x.kind), d["valid"] = x.valid;
              d["distance"] = x.distance_m, d["sigma"] = x.sigma_m, d["score"] = x.score;
              d["mirrored"] = x.mirrored;
              l.push_back(d);
            }
            return l;
          },
          "One dict per displacement measurement that took effect.")
      .def_readonly("warnings", &Outputs::warnings);
}
