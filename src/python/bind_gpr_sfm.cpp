// gprodom._core: feature matrices, matching and energy curves on numpy arrays.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <stdexcept>
#include <string>
#include <tuple>

#include "gpr/sequential/alignment.h"
#include "gpr/sequential/apexes.h"
#include "gpr/sequential/dec.h"
#include "gpr/sequential/sfm.h"
#include "python/choice_argument.h"

namespace py = pybind11;

namespace {

using gprodom::DistanceForm;
using gprodom::gpr::Aligner;
using gprodom::gpr::Alignment;
using gprodom::gpr::AlignmentOptions;
using gprodom::gpr::Apex;
using gprodom::gpr::ApexOptions;
using gprodom::gpr::CurveAligner;
using gprodom::gpr::CurveOptions;
using gprodom::gpr::CurveRefiner;
using gprodom::gpr::EnergyPoints;
using gprodom::gpr::FeaturePoint;
using gprodom::gpr::LevelMatrix;
using gprodom::gpr::ShiftDistances;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Traces = py::array_t<float, py::array::c_style | py::array::forcecast>;

AlignmentOptions options_from(const std::string& form, double min_overlap, int max_shift) {
  AlignmentOptions options;
  options.form = choice_argument<DistanceForm>("form", form);
  if (!(min_overlap >= 0.0 && min_overlap <= 1.0) || max_shift < 0) {
    throw std::invalid_argument("expected min_overlap from 0 to 1 and max_shift of 0 or more");
  }
  options.min_overlap = min_overlap;
  options.max_shift = max_shift;
  return options;
}

LevelMatrix feature_matrix(const Doubles& depth, const Doubles& position, const Doubles& amplitude,
                           int rows, int columns, double depth_range, double length,
                           double amplitude_scale) {
  if (depth.size() != position.size() || depth.size() != amplitude.size()) {
    throw std::invalid_argument("depth, position and amplitude must have the same length");
  }
  std::vector<FeaturePoint> points;
  points.reserve(static_cast<std::size_t>(depth.size()));
  for (py::ssize_t i = 0; i < depth.size(); ++i) {
    points.push_back({depth.data()[i], position.data()[i], amplitude.data()[i]});
  }
  LevelMatrix levels;
  build_sfm(points.data(), points.size(), {rows, columns, depth_range, length, amplitude_scale},
            levels);
  return levels;
}

using Aligned = std::tuple<Alignment, py::array_t<double>>;

Aligned with_distances(const Alignment& alignment, const ShiftDistances& distances) {
  return {alignment, py::array_t<double>(static_cast<py::ssize_t>(distances.distance.size()),
                                         distances.distance.data())};
}

Aligned align_levels(const LevelMatrix& a, const LevelMatrix& b, const std::string& form,
                     double min_overlap, int max_shift) {
  Aligner aligner(options_from(form, min_overlap, max_shift));
  const Alignment alignment = aligner.align(a, b);
  return with_distances(alignment, aligner.distances());
}

Aligned align_windows(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b, const std::string& form,
                      double min_overlap, int max_shift) {
  Aligner aligner(options_from(form, min_overlap, max_shift));
  const Alignment alignment = aligner.align(a, b);
  return with_distances(alignment, aligner.distances());
}

Aligned align_curves(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double min_overlap,
                     int max_shift) {
  CurveAligner aligner(options_from("cosine", min_overlap, max_shift));
  const Alignment alignment = aligner.align(a, b);
  return with_distances(alignment, aligner.distances());
}

Eigen::VectorXd dominant_energy_curve(const Traces& traces, int half_width, int first_row,
                                      double jump_penalty, int smoothing) {
  if (traces.ndim() != 2) throw std::invalid_argument("traces: expected shape (traces, samples)");
  const auto samples = static_cast<std::size_t>(traces.shape(1));
  if (first_row < 0 || static_cast<std::size_t>(first_row) + 3 > samples) {
    throw std::invalid_argument("first_row: expected at least three samples from it on");
  }
  std::vector<EnergyPoints> columns;
  std::vector<float> energy(samples);
  for (py::ssize_t i = 0; i < traces.shape(0); ++i) {
    gprodom::gpr::trace_energy(traces.data(i, 0), samples, half_width, energy.data());
    const double threshold =
        gprodom::gpr::background_threshold(energy.data() + first_row, samples - first_row);
    columns.push_back(gprodom::gpr::energy_points(energy.data(), samples, first_row, threshold));
  }
  Eigen::VectorXd curve;
  CurveRefiner(CurveOptions{jump_penalty, smoothing}).refine(columns, curve);
  return curve;
}

std::vector<Apex> apexes_of(const Traces& traces, double sample_interval, double time_zero,
                            double pulse, double first_time, double least_widening,
                            double most_widening) {
  if (traces.ndim() != 2) throw std::invalid_argument("traces: expected shape (traces, samples)");
  const Eigen::Map<const Eigen::MatrixXf> bscan(traces.data(), traces.shape(1), traces.shape(0));
  ApexOptions options;
  options.sample_interval_s = sample_interval;
  options.time_zero_s = time_zero;
  options.first_time_s = first_time;
  options.pulse_s = pulse;
  options.least_widening_s = least_widening;
  options.most_widening_s = most_widening;
  return gprodom::gpr::find_apexes(bscan, options);
}

}  // namespace

void bind_gpr_sfm(py::module_& module) {
  py::class_<Alignment>(module, "Alignment",
                        "Result of aligning one window with another; shifts in columns.")
      .def_readonly("valid", &Alignment::valid, "a minimum inside the limits, with energy")
      .def_readonly("shift", &Alignment::shift, "of the minimum, negative as traces enter")
      .def_readonly("subcolumn", &Alignment::subcolumn, "shift with its fraction")
      .def_readonly("variance", &Alignment::variance, "of subcolumn, columns^2")
      .def_readonly("distance", &Alignment::distance, "at the minimum")
      .def_readonly("overlap", &Alignment::overlap, "common columns at the minimum");

  module.def("build_sfm", &feature_matrix, py::arg("depth"), py::arg("position"),
             py::arg("amplitude"), py::kw_only(), py::arg("rows") = 50, py::arg("columns") = 50,
             py::arg("depth_range"), py::arg("length"), py::arg("amplitude_scale"),
             "Subsurface feature matrix, int8 (rows, columns), of peaks given as arrays of equal\n"
             "length; see gpr/sfm.h.");
  module.def("align_sfm", &align_levels, py::arg("a"), py::arg("b"), py::kw_only(),
             py::arg("form") = "cosine", py::arg("min_overlap") = 0.3, py::arg("max_shift") = 0,
             "Alignment of two feature matrices (rows, columns), and the distances (2 limit + 1)\n"
             "for the shifts -limit..limit; see gpr/alignment.h.");
  module.def("align_bscan", &align_windows, py::arg("a"), py::arg("b"), py::kw_only(),
             py::arg("form") = "cosine", py::arg("min_overlap") = 0.3, py::arg("max_shift") = 0,
             "The same for B-scan windows of real values, (samples, traces).");
  module.def("align_curves", &align_curves, py::arg("a"), py::arg("b"), py::kw_only(),
             py::arg("min_overlap") = 0.3, py::arg("max_shift") = 0,
             "The same for two dominant energy curves, (traces,) each; see gpr/dec.h.");
  module.def("dominant_energy_curve", &dominant_energy_curve, py::arg("traces"), py::kw_only(),
             py::arg("half_width") = 5, py::arg("first_row") = 20, py::arg("jump_penalty") = 0.01,
             py::arg("smoothing") = 7,
             "Row (samples) of the strongest reflector under each trace of (traces, samples),\n"
             "background removed; zeros where there is none; see gpr/dec.h.");
  py::class_<Apex>(module, "Apex", "Apex of a hyperbola in a B-scan.")
      .def_readonly("column", &Apex::column, "with its fraction")
      .def_readonly("time", &Apex::time_s, "s, two-way, from time zero")
      .def_readonly("widening", &Apex::widening_s, "s per column: 2 spacing / wave speed")
      .def_readonly("amplitude", &Apex::amplitude, "of the mean echo along the hyperbola")
      .def_readonly("semblance", &Apex::semblance, "stacked energy over energy, 0 to 1");
  module.def("find_apexes", &apexes_of, py::arg("traces"), py::kw_only(),
             py::arg("sample_interval"), py::arg("time_zero") = 0.0, py::arg("pulse") = 3e-9,
             py::arg("first_time") = 2e-9, py::arg("least_widening") = 0.0,
             py::arg("most_widening") = 0.0,
             "Apexes of hyperbolas in (traces, samples), background removed, the strongest first;\n"
             "see gpr/sequential/apexes.h.");
}
