// gprodom._core: feature matrices, matching and energy curves on numpy arrays.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <tuple>

#include "base/require.h"
#include "gpr/sequential/alignment.h"
#include "gpr/sequential/apexes.h"
#include "gpr/sequential/dec.h"
#include "gpr/sequential/sfm.h"
#include "python/arrays.h"
#include "python/choice_argument.h"

namespace py = pybind11;
using namespace py::literals;

namespace {

using namespace gprodom;
using namespace gprodom::gpr;

AlignmentOptions options_from(const std::string& form, double min_overlap, int max_shift) {
  AlignmentOptions options;
  options.form = choice_argument<DistanceForm>("form", form);
  require(min_overlap >= 0.0 && min_overlap <= 1.0 && max_shift >= 0,
          "expected min_overlap from 0 to 1 and max_shift of 0 or more");
  options.min_overlap = min_overlap;
  options.max_shift = max_shift;
  return options;
}

LevelMatrix feature_matrix(const Doubles& depth, const Doubles& position, const Doubles& amplitude,
                           int rows, int columns, double depth_range, double length,
                           double amplitude_scale) {
  require(depth.size() == position.size() && depth.size() == amplitude.size(),
          "depth, position and amplitude must have the same length");
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

template <class Aligner, class Window>
Aligned aligned(const AlignmentOptions& options, const Window& a, const Window& b) {
  Aligner aligner(options);
  const Alignment alignment = aligner.align(a, b);
  return {alignment, column_of<double>(aligner.distances().distance)};
}

template <class Window>
Aligned align_windows(const Window& a, const Window& b, const std::string& form, double min_overlap,
                      int max_shift) {
  return aligned<Aligner>(options_from(form, min_overlap, max_shift), a, b);
}

Aligned align_curves(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double min_overlap,
                     int max_shift) {
  return aligned<CurveAligner>(options_from("cosine", min_overlap, max_shift), a, b);
}

Eigen::VectorXd dominant_energy_curve(const Floats& traces, int half_width, int first_row,
                                      double jump_penalty, int smoothing) {
  require(traces.ndim() == 2, "traces: expected shape (traces, samples)");
  const auto samples = static_cast<std::size_t>(traces.shape(1));
  require(first_row >= 0 && static_cast<std::size_t>(first_row) + 3 <= samples,
          "first_row: expected at least three samples from it on");
  std::vector<EnergyPoints> columns;
  std::vector<float> energy(samples);
  for (py::ssize_t i = 0; i < traces.shape(0); ++i) {
    trace_energy(traces.data(i, 0), samples, half_width, energy.data());
    const double threshold = background_threshold(energy.data() + first_row, samples - first_row);
    columns.push_back(energy_points(energy.data(), samples, first_row, threshold));
  }
  Eigen::VectorXd curve;
  CurveRefiner(CurveOptions{jump_penalty, smoothing}).refine(columns, curve);
  return curve;
}

std::vector<Apex> apexes_of(const Floats& traces, double sample_interval, double time_zero,
                            double pulse, double first_time, double least_widening,
                            double most_widening) {
  require(traces.ndim() == 2, "traces: expected shape (traces, samples)");
  const Eigen::Map<const Eigen::MatrixXf> bscan(traces.data(), traces.shape(1), traces.shape(0));
  ApexOptions options;
  options.sample_interval_s = sample_interval;
  options.time_zero_s = time_zero;
  options.first_time_s = first_time;
  options.pulse_s = pulse;
  options.least_widening_s = least_widening;
  options.most_widening_s = most_widening;
  return find_apexes(bscan, options);
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

  module.def("build_sfm", &feature_matrix, "depth"_a, "position"_a, "amplitude"_a, py::kw_only(),
             "rows"_a = 50, "columns"_a = 50, "depth_range"_a, "length"_a, "amplitude_scale"_a,
             "Subsurface feature matrix, int8 (rows, columns), of peaks given as arrays of equal\n"
             "length; see gpr/sfm.h.");
  module.def("align_sfm", &align_windows<LevelMatrix>, "a"_a, "b"_a, py::kw_only(),
             "form"_a = "cosine", "min_overlap"_a = 0.3, "max_shift"_a = 0,
             "Alignment of two feature matrices (rows, columns), and the distances (2 limit + 1)\n"
             "for the shifts -limit..limit; see gpr/alignment.h.");
  module.def("align_bscan", &align_windows<Eigen::MatrixXf>, "a"_a, "b"_a, py::kw_only(),
             "form"_a = "cosine", "min_overlap"_a = 0.3, "max_shift"_a = 0,
             "The same for B-scan windows of real values, (samples, traces).");
  module.def("align_curves", &align_curves, "a"_a, "b"_a, py::kw_only(), "min_overlap"_a = 0.3,
             "max_shift"_a = 0,
             "The same for two dominant energy curves, (traces,) each; see gpr/dec.h.");
  module.def("dominant_energy_curve", &dominant_energy_curve, "traces"_a, py::kw_only(),
             "half_width"_a = 5, "first_row"_a = 20, "jump_penalty"_a = 0.01, "smoothing"_a = 7,
             "Row (samples) of the strongest reflector under each trace of (traces, samples),\n"
             "background removed; zeros where there is none; see gpr/dec.h.");
  py::class_<Apex>(module, "Apex", "Apex of a hyperbola in a B-scan.")
      .def_readonly("column", &Apex::column, "with its fraction")
      .def_readonly("time", &Apex::time_s, "s, two-way, from time zero")
      .def_readonly("widening", &Apex::widening_s, "s per column: 2 spacing / wave speed")
      .def_readonly("amplitude", &Apex::amplitude, "of the mean echo along the hyperbola")
      .def_readonly("semblance", &Apex::semblance, "stacked energy over energy, 0 to 1");
  module.def("find_apexes", &apexes_of, "traces"_a, py::kw_only(), "sample_interval"_a,
             "time_zero"_a = 0.0, "pulse"_a = 3e-9, "first_time"_a = 2e-9, "least_widening"_a = 0.0,
             "most_widening"_a = 0.0,
             "Apexes of hyperbolas in (traces, samples), background removed, the strongest first;\n"
             "see gpr/sequential/apexes.h.");
}
