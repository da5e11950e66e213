// gprodom.gpr: inputs and findings of a radar front end, for front ends written in Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "python/python_front_end.h"

namespace py = pybind11;
using namespace py::literals;
using namespace gprodom;

namespace {

// Its functions are called from Odometry.step(), which does not hold the interpreter lock.
class PythonFrontEnd : public gpr::FrontEnd {
 public:
  // With the lock held. Throws py::type_error if the object lacks a function.
  explicit PythonFrontEnd(py::object object) : object_(std::move(object)) {
    for (const char* function : {"add_trace", "tick", "reset"})
      if (!py::hasattr(object_, function))
        throw py::type_error(std::string("front_end: expected a class with add_trace(trace), "
                                         "tick(time) and reset(); there is no ") +
                             function);
  }
  ~PythonFrontEnd() override {
    const py::gil_scoped_acquire lock;
    object_ = py::object();
  }
  PythonFrontEnd(const PythonFrontEnd&) = delete;
  PythonFrontEnd& operator=(const PythonFrontEnd&) = delete;

  void add_trace(const GprTrace& trace) override {
    const py::gil_scoped_acquire lock;
    object_.attr("add_trace")(trace);
  }
  std::vector<gpr::Finding> tick(TimeNs tick) override {
    const py::gil_scoped_acquire lock;
    const py::object said = object_.attr("tick")(tick);
    try {
      return said.cast<std::vector<gpr::Finding>>();
    } catch (const py::cast_error&) {
      throw py::type_error(
          "tick(): expected a list of Standstill, PathLength, TrackDisplacement and Sight, got " +
          std::string(py::repr(said)));
    }
  }
  void reset() override {
    const py::gil_scoped_acquire lock;
    object_.attr("reset")();
  }

 private:
  py::object object_;
};

}  // namespace

gpr::FrontEndFactory python_front_end(const py::object& make) {
  if (make.is_none()) return {};
  // Shared, since factories are copied without the lock.
  const std::shared_ptr<py::object> kept(new py::object(make), [](py::object* object) {
    const py::gil_scoped_acquire lock;
    delete object;
  });
  return [kept] {
    const py::gil_scoped_acquire lock;
    return std::make_unique<PythonFrontEnd>((*kept)());
  };
}

void bind_front_end(py::module_& module) {
  py::class_<GprTrace>(module, "GprTrace", "One radar trace, in counts.")
      .def_readonly("time", &GprTrace::time, "ns")
      .def_readonly("seq", &GprTrace::seq)
      .def_readonly("sample_interval", &GprTrace::sample_interval_s, "s")
      .def_readonly("time_zero", &GprTrace::time_zero_s,
                    "s; sample i was taken i sample_interval - time_zero after the pulse left")
      .def_property_readonly(
          "samples",
          [](const GprTrace& t) {
            return py::array_t<float>(static_cast<py::ssize_t>(t.samples.size()), t.samples.data());
          },
          "(samples,) float32, a copy");
  py::class_<gpr::Standstill>(
      module, "Standstill",
      "The antenna stood between two times (ns). sigma: motion that the test may have missed, m.\n"
      "since: the antenna has not moved since this time, because the traces then and now are\n"
      "equal; 0: not compared.")
      .def(py::init([](TimeNs from, TimeNs to, double sigma, std::string source, double score,
                       TimeNs since) {
             return gpr::Standstill{from, to, std::move(source), sigma, score, since};
           }),
           "time_from"_a, "time_to"_a, "sigma"_a, "source"_a = "python", "score"_a = 0.0,
           "since"_a = 0);
  py::class_<gpr::PathLength>(module, "PathLength",
                              "Unsigned distance that the antenna moved, in a unit of the ground "
                              "that the estimator converts to metres. valid: False if the distance "
                              "is not known. unit: lengths of another number cannot be compared.")
      .def(py::init([](TimeNs from, TimeNs to, double lengths, bool valid, std::string source,
                       double score, int unit) {
             return gpr::PathLength{from, to, std::move(source), valid, lengths, score, unit};
           }),
           "time_from"_a, "time_to"_a, "lengths"_a, "valid"_a = true, "source"_a = "python",
           "score"_a = 0.0, "unit"_a = 0);
  py::class_<gpr::TrackDisplacement>(
      module, "TrackDisplacement",
      "Signed distance that the antenna moved along its track, m, forwards positive; sigma: its "
      "standard deviation, m. valid: False if the distance is not known.")
      .def(py::init([](TimeNs from, TimeNs to, double distance, double sigma, bool valid,
                       std::string source, double score) {
             return gpr::TrackDisplacement{from,  to,   std::move(source), valid, distance,
                                           sigma, score};
           }),
           "time_from"_a, "time_to"_a, "distance"_a, "sigma"_a, "valid"_a = true,
           "source"_a = "python", "score"_a = 0.0);
  py::class_<gpr::Sight>(
      module, "Sight",
      "The antenna moved at times_least times the slowest speed that the Standstill test detects.")
      .def(py::init<TimeNs, TimeNs, double>(), "time_from"_a, "time_to"_a, "times_least"_a);
}
