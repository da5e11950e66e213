// gprodom.Odometry: the estimator in-process, the same code as the daemon's.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/require.h"
#include "estimation/initializer.h"
#include "gprodom/config.h"
#include "gprodom/error.h"
#include "gprodom/input.h"
#include "gprodom/odometry.h"
#include "python/arrays.h"
#include "python/python_front_end.h"

namespace py = pybind11;
using namespace py::literals;

namespace gprodom {
namespace {

// One text or several; an empty one is none.
using Texts = std::variant<std::string, std::vector<std::string>>;

std::vector<std::string> list_of(const Texts& texts) {
  if (const auto* several = std::get_if<std::vector<std::string>>(&texts)) return *several;
  const auto& one = std::get<std::string>(texts);
  if (one.empty()) return {};
  return {one};
}

Eigen::Vector3d row3(const Doubles& a, py::ssize_t i) {
  return {a.at(i, 0), a.at(i, 1), a.at(i, 2)};
}

void check_rows(const py::array& time, const Doubles& values, py::ssize_t columns,
                const char* what) {
  require(time.ndim() == 1 && values.ndim() == 2 && values.shape(0) == time.shape(0) &&
              values.shape(1) == columns,
          what);
}

// Only integers: float seconds would silently be truncated to nanoseconds.
Times nanoseconds(const py::object& given, const std::string& name) {
  const py::array times = py::array::ensure(given);
  if (!times) throw py::value_error(name + ": expected an array of integers, nanoseconds");
  if (times.size() == 0) return Times(py::ssize_t{0});
  const char kind = times.dtype().kind();
  if (kind != 'i' && kind != 'u')
    throw py::value_error(name + ": expected nanoseconds as integers (int64), got " +
                          std::string(py::str(times.dtype())) +
                          "; of float seconds: np.rint(t * 1e9).astype(np.int64)");
  return Times::ensure(times);
}

// The estimator with a check that times can be nanoseconds. With microseconds there would be no
// poses and no error, since each of them is a valid time.
class PythonOdometry : public Odometry {
 public:
  using Odometry::Odometry;

  void add_imu(const ImuSample& sample) {
    if (seen_ < kSamples) {
      first_ = seen_ == 0 ? sample.time : std::min(first_, sample.time);
      newest_ = seen_ == 0 ? sample.time : std::max(newest_, sample.time);
      if (++seen_ == kSamples && newest_ - first_ < kSamples * kLeastInterval)
        throw py::value_error(
            "IMU times: " + std::to_string(kSamples) + " samples within " +
            std::to_string(newest_ - first_) +
            " ns; expected nanoseconds (of microseconds: t * 1000), at 50 kHz or less");
    }
    add(sample);
  }

 private:
  static constexpr int kSamples = 100;
  static constexpr TimeNs kLeastInterval = 20'000;  // ns; no IMU is faster

  int seen_ = 0;
  TimeNs first_ = 0, newest_ = 0;
};

// A sensor whose times do not overlap with the IMU's has another unit or another clock.
void require_overlap(const Times& imu, const Times& other, const std::string& name) {
  if (imu.size() == 0 || other.size() == 0) return;
  const auto [imu_first, imu_last] = std::minmax_element(imu.data(), imu.data() + imu.size());
  const auto [first, last] = std::minmax_element(other.data(), other.data() + other.size());
  if (*last < *imu_first || *first > *imu_last)
    throw py::value_error(name + ": from " + std::to_string(*first) + " to " +
                          std::to_string(*last) + " ns, no overlap with imu_time (" +
                          std::to_string(*imu_first) + " to " + std::to_string(*imu_last) + ")");
}

void append(Outputs& all, Outputs out) {
  const auto move = [](auto& to, auto& from) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
  };
  move(all.odometry, out.odometry);
  move(all.odometry_in_map, out.odometry_in_map);
  move(all.corrections, out.corrections);
  move(all.sfm, out.sfm);
  move(all.displacements, out.displacements);
  move(all.status, out.status);
  move(all.warnings, out.warnings);
}

// Runs a whole sequence, merged by stamp (at equal stamps IMU first, then wheel, then radar). Much
// faster than one call per message.
Outputs run(PythonOdometry& odometry, const py::object& imu_times, const Doubles& acceleration,
            const Doubles& rate, const py::object& wheel_times, const Doubles& wheel_distance,
            const py::object& gpr_times, const Floats& traces, double sample_interval,
            const std::optional<std::function<void(double)>>& progress, double wheel_resolution,
            const std::optional<Array<std::int32_t>>& antennas) {
  const Times imu_time = nanoseconds(imu_times, "imu_time"),
              wheel_time = nanoseconds(wheel_times, "wheel_time"),
              gpr_time = nanoseconds(gpr_times, "gpr_time");
  require_overlap(imu_time, wheel_time, "wheel_time");
  require_overlap(imu_time, gpr_time, "gpr_time");
  check_rows(imu_time, acceleration, 3,
             "acceleration: expected an array (n, 3) beside imu_time (n,)");
  check_rows(imu_time, rate, 3, "angular_velocity: expected an array (n, 3) beside imu_time (n,)");
  const bool pair = wheel_distance.ndim() == 2;
  require(wheel_time.ndim() == 1 && wheel_distance.ndim() >= 1 && wheel_distance.ndim() <= 2 &&
              wheel_time.shape(0) == wheel_distance.shape(0) &&
              (!pair || wheel_distance.shape(1) == 2),
          "wheel_distance: expected an array (n,), or (n, 2) of left and right, beside wheel_time "
          "(n,)");
  require(gpr_time.shape(0) == 0 || (traces.ndim() == 2 && traces.shape(0) == gpr_time.shape(0)),
          "traces: expected an array (n, samples) beside gpr_time (n,)");
  require(!antennas || (antennas->ndim() == 1 && antennas->shape(0) == gpr_time.shape(0)),
          "gpr_antenna: expected an array (n,) beside gpr_time (n,)");
  std::map<std::int32_t, std::int64_t> seen;  // traces so far, by antenna
  Outputs all;
  py::ssize_t i = 0, w = 0, g = 0;
  const py::ssize_t n = imu_time.shape(0), nw = wheel_time.shape(0), ng = gpr_time.shape(0);
  while (i < n || w < nw || g < ng) {
    constexpr auto kNever = std::numeric_limits<std::int64_t>::max();
    const std::int64_t ti = i < n ? imu_time.at(i) : kNever,
                       tw = w < nw ? wheel_time.at(w) : kNever,
                       tg = g < ng ? gpr_time.at(g) : kNever;
    if (ti <= tw && ti <= tg) {
      odometry.add_imu(ImuSample{ti, row3(acceleration, i), row3(rate, i)});
      if (++i % 2000 == 0 && progress) (*progress)(static_cast<double>(i) / static_cast<double>(n));
    } else if (tw <= tg) {
      if (pair)
        odometry.add(
            WheelsSample{tw, wheel_distance.at(w, 0), wheel_distance.at(w, 1), wheel_resolution});
      else
        odometry.add(WheelSample{tw, wheel_distance.at(w), wheel_resolution});
      ++w;
    } else {
      GprTrace trace;
      trace.time = tg;
      trace.antenna_id = antennas ? antennas->at(g) : 0;
      trace.seq = seen[trace.antenna_id]++;
      trace.sample_interval_s = sample_interval;
      trace.samples.assign(traces.data(g, 0), traces.data(g, 0) + traces.shape(1));
      ++g;
      odometry.add(trace);
    }
    append(all, odometry.step());
  }
  append(all, odometry.finish());
  return all;
}

}  // namespace
}  // namespace gprodom

void bind_odometry(py::module_& m) {
  using namespace gprodom;
  m.def(
      "describe_config",
      [](const Texts& set) { return describe_config(default_config(list_of(set))); },
      "set"_a = std::vector<std::string>{},
      "Every key with unit and comment as YAML, at the defaults or with an override 'key=value' or "
      "several.");
  m.def("accel_scale_at_rest", accel_scale_at_rest, "force"_a,
        "The scale that the estimator takes an accelerometer to have whose mean specific force at "
        "rest has this norm (m/s^2): 1 if a bias explains it, or if it is no scale.");
  py::enum_<CommandName> command(m, "CommandName", "Names of the commands in command_t.");
  for (const char* name : names_like(CommandName{}))
    command.value(name, *find_choice<CommandName>(name));
  m.attr("RESET_ALL") = kResetAll;
  py::register_exception<ConfigError>(m, "ConfigError", PyExc_ValueError);
  py::register_exception<FileError>(m, "FileError", PyExc_OSError);
  py::class_<PythonOdometry>(
      m, "Odometry",
      "The estimator. Times in ns, SI units; IMU in its own axes, see config imu.rpy_body_imu.")
      .def(py::init([](const Texts& config, const Texts& set, const py::object& front_end) {
             std::vector<std::string> notices;
             const Config read = load_config(list_of(config), list_of(set), &notices);
             warn(notices);
             return std::make_unique<PythonOdometry>(read, Execution::kInline,
                                                     python_front_end(front_end));
           }),
           "config"_a = "", "set"_a = std::vector<std::string>{}, "front_end"_a = py::none(),
           "config: path of a YAML file, or several, of which later ones override earlier ones;\n"
           "empty for the defaults. set: an override 'key=value', or several. Raises ConfigError\n"
           "with file, line and key. front_end: a radar front end of your own instead of\n"
           "gpr.front_end: a class, or another callable without arguments, whose objects have\n"
           "add_trace(trace: GprTrace), tick(time: int) -> list of findings and reset().")
      .def(
          "add_imu",
          [](PythonOdometry& o, std::int64_t time, const Eigen::Vector3d& acceleration,
             const Eigen::Vector3d& rate) {
            o.add_imu(ImuSample{time, acceleration, rate});
          },
          "time"_a, "acceleration"_a, "angular_velocity"_a,
          "acceleration: (3,) m/s^2, specific force; angular_velocity: (3,) rad/s.")
      .def(
          "add_wheel",
          [](PythonOdometry& o, std::int64_t time, double distance, double resolution) {
            o.add(WheelSample{time, distance, resolution});
          },
          "time"_a, "distance"_a, "resolution"_a = 0.0,
          "distance: signed, cumulative, metres; resolution: of one tick of the encoder, metres,\n"
          "0 if it is finer than wheel.noise_floor.")
      .def(
          "add_wheels",
          [](PythonOdometry& o, std::int64_t time, double left, double right, double resolution) {
            o.add(WheelsSample{time, left, right, resolution});
          },
          "time"_a, "left"_a, "right"_a, "resolution"_a = 0.0,
          "left, right: signed, cumulative, metres; resolution: as of add_wheel. Instead of "
          "add_wheel.")
      .def(
          "add_gpr",
          [](PythonOdometry& o, std::int64_t time, const std::vector<float>& samples,
             double sample_interval, double time_zero, std::int64_t seq, int antenna_id) {
            GprTrace t;
            t.time = time, t.seq = seq, t.sample_interval_s = sample_interval;
            t.time_zero_s = time_zero, t.samples = samples, t.antenna_id = antenna_id;
            o.add(t);
          },
          "time"_a, "samples"_a, "sample_interval"_a, "time_zero"_a = 0.0, "seq"_a = 0,
          "antenna_id"_a = 0,
          "samples: (n,) counts; sample_interval and time_zero: s; antenna_id: of gpr.antennas.")
      .def(
          "add_displacement",
          [](PythonOdometry& o, std::int64_t time, std::int64_t from, std::int64_t to,
             double distance, double sigma, bool revisit, bool mirrored) {
            Displacement d;
            d.time = time, d.from = from, d.to = to, d.distance_m = distance, d.sigma_m = sigma;
            d.kind = revisit ? DisplacementKind::kRevisit : DisplacementKind::kExternal;
            d.valid = true, d.mirrored = mirrored;
            o.add(d);
          },
          "time"_a, "time_from"_a, "time_to"_a, "distance"_a, "sigma"_a, "revisit"_a = false,
          "mirrored"_a = false,
          "Displacement along the track (m) between two times, from another process. revisit: it\n"
          "is relative to a place passed before, at any earlier time.")
      .def(
          "add_fix",
          [](PythonOdometry& o, std::int64_t time, const Eigen::Vector3d& position,
             const Eigen::Matrix3d& covariance, bool geodetic, int quality, int antenna_id,
             std::optional<double> heading, double heading_sigma) {
            PositionFix fix;
            fix.time = time, fix.position = position, fix.covariance = covariance;
            fix.frame = geodetic ? FixFrame::kGeodetic : FixFrame::kSite;
            require(quality >= 0 && quality <= 4, "quality: expected 0 to 4, as in position_fix_t");
            fix.quality = static_cast<FixQuality>(quality), fix.antenna_id = antenna_id;
            fix.has_heading = heading.has_value(), fix.heading = heading.value_or(0.0);
            fix.heading_sigma = heading_sigma;
            o.add(fix);
          },
          "time"_a, "position"_a, "covariance"_a, "geodetic"_a = false, "quality"_a = 3,
          "antenna_id"_a = 0, "heading"_a = py::none(), "heading_sigma"_a = 0.0,
          "A position from outside, as position_fix_t has it. position: (3,) m in site, or "
          "latitude,\nlongitude (deg) and height (m); covariance: (3, 3) m^2.")
      .def("step", &Odometry::step, py::call_guard<py::gil_scoped_release>(),
           "What the data since the last step gave.")
      .def("finish", &Odometry::finish, py::call_guard<py::gil_scoped_release>(),
           "The same at the end of the data: nothing more will come.")
      .def(
          "reset", &Odometry::reset,
          "Restarts at the initialiser. The ground driven over is kept; when it is recognised, map "
          "becomes its frame.")
      .def("forget", &Odometry::forget, "Restarts and forgets the ground too.")
      .def("save_map", &Odometry::save_map, "path"_a,
           "Saves the ground driven over, with its poses, to a file. Raises FileError.")
      .def("load_map", &Odometry::load_map, "path"_a,
           "Loads the ground of a saved map; when it is recognised, map becomes its frame.\n"
           "Raises FileError, and then nothing has changed.")
      .def(
          "locate_at",
          [](PythonOdometry& o, double x, double y, double yaw, double sigma, int map) {
            o.locate_at({x, y, yaw, sigma, map});
          },
          "x"_a, "y"_a, "yaw"_a, "sigma"_a, "map"_a = -1,
          "The robot is now about there in the map of earlier ground (m, rad; sigma: of the\n"
          "position, m; map: its number, -1: the one with the most ground). That ground is\n"
          "searched first; map becomes its frame once a revisit has proved it. Raises FileError\n"
          "where there is no map, ValueError on figures that make no sense.")
      .def("record", &Odometry::record,
           "Keep all states for smoothed(); call it before the first measurement.")
      .def(
          "recorded", [](const PythonOdometry& o) { return estimate_arrays(o.recorded()); },
          "Time, position and orientation of every state as it left the fixed-lag window.")
      .def(
          "smoothed", [](const PythonOdometry& o) { return estimate_arrays(o.smoothed()); },
          "Time, position and orientation of every state from one solution over all data so far.")
      .def("run", &run, "imu_time"_a, "acceleration"_a, "angular_velocity"_a, "wheel_time"_a,
           "wheel_distance"_a, "gpr_time"_a, "traces"_a, "sample_interval"_a = 2e-10,
           "progress"_a = py::none(), "wheel_resolution"_a = 0.0, "gpr_antenna"_a = py::none(),
           "Runs a whole sequence, merged by stamp. Give empty arrays for a missing sensor. Times\n"
           "are integers, nanoseconds; others raise ValueError.\n"
           "wheel_distance: (n,), or (n, 2) of left and right wheels; wheel_resolution: as of\n"
           "add_wheel; gpr_antenna: (n,) the antenna_id of each trace, None: 0.");
}
