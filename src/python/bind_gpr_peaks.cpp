// gprodom._core: peaks of filtered traces on numpy arrays.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "gpr/peaks/peaks.h"
#include "gpr/peaks/peaks_envelope.h"
#include "python/arrays.h"

namespace py = pybind11;
using namespace py::literals;

namespace {

using namespace gprodom;
using namespace gprodom::gpr;

py::array_t<float> envelope(const Floats& trace) {
  require_shape(trace, 1, "(samples,)");
  AnalyticSignal signal;
  analytic_signal(trace.data(), static_cast<std::size_t>(trace.size()), signal);
  return column_of<float>(signal.envelope);
}

std::vector<std::vector<Peak>> extract_all(PeakExtractor& extractor, const Floats& traces) {
  require_shape(traces, 2, "(traces, samples)");
  std::vector<std::vector<Peak>> peaks;
  for (py::ssize_t i = 0; i < traces.shape(0); ++i) {
    peaks.push_back(
        extractor.extract(traces.data(i, 0), static_cast<std::size_t>(traces.shape(1))));
  }
  return peaks;
}

}  // namespace

void bind_gpr_peaks(py::module_& module) {
  const PeakOptions defaults;
  py::class_<PeakOptions>(module, "PeakOptions", "How peaks are found and fitted; see gpr/peaks.h.")
      .def(py::init<bool, double, double, double, double, int, double, double, int>(),
           py::kw_only(), "fit"_a = defaults.fit, "noise_sigma"_a = defaults.noise_sigma,
           "min_snr"_a = defaults.min_snr, "min_relative"_a = defaults.min_relative,
           "gate_periods"_a = defaults.gate_periods, "max_joint"_a = defaults.max_joint,
           "significance"_a = defaults.significance, "max_residual"_a = defaults.max_residual,
           "max_iterations"_a = defaults.max_iterations)
      .def_readwrite("fit", &PeakOptions::fit)
      .def_readwrite("noise_sigma", &PeakOptions::noise_sigma)
      .def_readwrite("min_snr", &PeakOptions::min_snr)
      .def_readwrite("min_relative", &PeakOptions::min_relative)
      .def_readwrite("gate_periods", &PeakOptions::gate_periods)
      .def_readwrite("max_joint", &PeakOptions::max_joint)
      .def_readwrite("significance", &PeakOptions::significance)
      .def_readwrite("max_residual", &PeakOptions::max_residual)
      .def_readwrite("max_iterations", &PeakOptions::max_iterations);

  py::class_<Peak>(module, "Peak", "A reflection; times in samples, see gpr/peaks.h.")
      .def_readonly("sample", &Peak::sample)
      .def_readonly("amplitude", &Peak::amplitude)
      .def_readonly("alpha", &Peak::alpha)
      .def_readonly("beta", &Peak::beta)
      .def_readonly("gamma", &Peak::gamma)
      .def_readonly("omega", &Peak::omega)
      .def_readonly("phi", &Peak::phi)
      .def_readonly("residual", &Peak::residual)
      .def_readonly("gate_begin", &Peak::gate_begin)
      .def_readonly("gate_end", &Peak::gate_end)
      .def_readonly("joint", &Peak::joint)
      .def_property_readonly(
          "covariance", [](const Peak& peak) { return peak.covariance; },
          "7x7: sample, amplitude, alpha, beta, gamma, omega, phi");

  py::class_<PeakCounts>(module, "PeakCounts", "Counts of all pulses so far, by result.")
      .def_readonly("traces", &PeakCounts::traces)
      .def_readonly("pulses", &PeakCounts::pulses)
      .def_readonly("accepted", &PeakCounts::accepted)
      .def_readonly("insignificant", &PeakCounts::insignificant)
      .def_readonly("not_converged", &PeakCounts::not_converged)
      .def_readonly("out_of_bounds", &PeakCounts::out_of_bounds)
      .def_readonly("misfit", &PeakCounts::misfit);

  py::class_<PeakExtractor>(module, "PeakExtractor", "Peaks of filtered traces.")
      .def(py::init<const PeakOptions&>(), py::arg_v("options", PeakOptions{}, "PeakOptions()"))
      .def(
          "extract",
          [](PeakExtractor& extractor, const Floats& trace) {
            require_shape(trace, 1, "(samples,)");
            return extractor.extract(trace.data(), static_cast<std::size_t>(trace.size()));
          },
          "trace"_a, "Peaks of one trace (samples,), in order of time.")
      .def("extract_all", &extract_all, "traces"_a,
           "Peaks of each row of (traces, samples): a list per trace.")
      .def_property_readonly("counts", &PeakExtractor::counts);

  module.def("envelope", &envelope, "trace"_a,
             "Hilbert envelope of a trace (samples,), its mean removed.");
  module.def("travel_time", &travel_time, "sample"_a, "sample_interval_s"_a, "time_zero_s"_a,
             "Two-way travel time (s) of a sub-sample index.");
  module.def("depth_of", &depth_of, "travel_time_s"_a, "wave_speed"_a,
             "Depth (m) of a reflector at a two-way travel time (s).");
  module.def("depth_row", &depth_row, "depth"_a, "depth_range"_a, "rows"_a,
             "Row of a depth (m); -1 outside [0, depth_range).");
}
