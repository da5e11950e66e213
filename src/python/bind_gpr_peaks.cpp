// gprodom._core: peaks of filtered traces on numpy arrays.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <stdexcept>
#include <utility>

#include "gpr/peaks/peaks.h"
#include "gpr/peaks/peaks_envelope.h"

namespace py = pybind11;

namespace {

using gprodom::gpr::Peak;
using gprodom::gpr::PeakCounts;
using gprodom::gpr::PeakExtractor;
using gprodom::gpr::PeakOptions;
using Trace = py::array_t<float, py::array::c_style | py::array::forcecast>;

void require_dimensions(const Trace& array, py::ssize_t dimensions, const char* shape) {
  if (array.ndim() != dimensions) {
    throw std::invalid_argument(std::string("expected an array of shape ") + shape);
  }
}

py::array_t<double> covariance(const Peak& peak) {
  py::array_t<double> out({7, 7});
  auto view = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < 7; ++i) {
    for (py::ssize_t j = 0; j < 7; ++j) view(i, j) = peak.covariance(i, j);
  }
  return out;
}

py::array_t<float> envelope(const Trace& trace) {
  require_dimensions(trace, 1, "(samples,)");
  gprodom::gpr::AnalyticSignal signal;
  gprodom::gpr::analytic_signal(trace.data(), static_cast<std::size_t>(trace.size()), signal);
  return py::array_t<float>(static_cast<py::ssize_t>(signal.envelope.size()),
                            signal.envelope.data());
}

std::vector<std::vector<Peak>> extract_all(PeakExtractor& extractor, const Trace& traces) {
  require_dimensions(traces, 2, "(traces, samples)");
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
      .def(py::init([](bool fit, double noise_sigma, double min_snr, double min_relative,
                       double gate_periods, int max_joint, double significance, double max_residual,
                       int max_iterations) {
             return PeakOptions{fit,       noise_sigma,  min_snr,      min_relative,  gate_periods,
                                max_joint, significance, max_residual, max_iterations};
           }),
           py::kw_only(), py::arg("fit") = defaults.fit,
           py::arg("noise_sigma") = defaults.noise_sigma, py::arg("min_snr") = defaults.min_snr,
           py::arg("min_relative") = defaults.min_relative,
           py::arg("gate_periods") = defaults.gate_periods,
           py::arg("max_joint") = defaults.max_joint,
           py::arg("significance") = defaults.significance,
           py::arg("max_residual") = defaults.max_residual,
           py::arg("max_iterations") = defaults.max_iterations)
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
      .def_property_readonly("covariance", &covariance,
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
          [](PeakExtractor& extractor, const Trace& trace) {
            require_dimensions(trace, 1, "(samples,)");
            return extractor.extract(trace.data(), static_cast<std::size_t>(trace.size()));
          },
          py::arg("trace"), "Peaks of one trace (samples,), in order of time.")
      .def("extract_all", &extract_all, py::arg("traces"),
           "Peaks of each row of (traces, samples): a list per trace.")
      .def_property_readonly("counts", &PeakExtractor::counts);

  module.def("envelope", &envelope, py::arg("trace"),
             "Hilbert envelope of a trace (samples,), its mean removed.");
  module.def("travel_time", &gprodom::gpr::travel_time, py::arg("sample"),
             py::arg("sample_interval_s"), py::arg("time_zero_s"),
             "Two-way travel time (s) of a sub-sample index.");
  module.def("depth_of", &gprodom::gpr::depth_of, py::arg("travel_time_s"), py::arg("wave_speed"),
             "Depth (m) of a reflector at a two-way travel time (s).");
  module.def("depth_row", &gprodom::gpr::depth_row, py::arg("depth"), py::arg("depth_range"),
             py::arg("rows"), "Row of a depth (m); -1 outside [0, depth_range).");
}
