// gprodom._core: details retention, its steps, and standstills, on numpy arrays.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/require.h"
#include "gpr/filter/details_retention.h"
#include "gpr/motion/coherence.h"
#include "gpr/motion/stationarity.h"
#include "python/arrays.h"
#include "python/choice_argument.h"

namespace py = pybind11;
using namespace py::literals;

namespace {

using namespace gprodom;
using namespace gprodom::gpr;

// `step(in, samples, out)` on each trace of (traces, samples) or (samples,), into a new array.
template <typename T, typename Step>
py::array_t<T> each_trace(const Array<T>& traces, Step step) {
  require(traces.ndim() == 1 || traces.ndim() == 2,
          "expected an array of shape (traces, samples) or (samples,)");
  const py::ssize_t n = traces.shape(traces.ndim() - 1);
  py::array_t<T> out(std::vector<py::ssize_t>(traces.shape(), traces.shape() + traces.ndim()));
  for (py::ssize_t i = 0; n > 0 && i < traces.size() / n; ++i) {
    step(traces.data() + i * n, static_cast<int>(n), out.mutable_data() + i * n);
  }
  return out;
}

py::array_t<double> band_pass(const Doubles& traces, double sample_interval, double low,
                              double high, double length) {
  ZeroPhaseFilter<double> filter(design_band_pass(low, high, sample_interval, length));
  return each_trace<double>(
      traces, [&filter](const double* x, int n, double* out) { filter.apply(x, n, out); });
}

py::array_t<double> dewow_traces(const Doubles& traces, int half_width) {
  require(half_width >= 0, "half_width: expected 0 or more");
  return each_trace<double>(
      traces, [half_width](const double* x, int n, double* out) { dewow(x, n, half_width, out); });
}

py::array_t<float> remove_background(const Floats& traces, const std::string& mode, int memory) {
  require_shape(traces, 2, "(traces, samples)");
  if (mode == "sequence") {
    py::array_t<float> out({traces.shape(0), traces.shape(1)});
    Eigen::Map<Eigen::MatrixXf> bscan(out.mutable_data(), traces.shape(1), traces.shape(0));
    bscan = Eigen::Map<const Eigen::MatrixXf>(traces.data(), traces.shape(1), traces.shape(0));
    remove_mean_trace(bscan);
    return out;
  }
  require(mode == "running" || mode == "window",
          "mode: expected 'sequence', 'running' or 'window'");
  RunningBackground background(
      mode == "running" ? RunningBackground::Mode::kRunning : RunningBackground::Mode::kWindow,
      memory);
  return each_trace<float>(traces, [&background](const float* x, int n, float* out) {
    std::copy_n(x, n, out);
    background.remove(out, n);
  });
}

std::tuple<py::array_t<float>, py::array_t<double>> track_time_zero(const Floats& traces,
                                                                    double period,
                                                                    double max_delay) {
  require_shape(traces, 2, "(traces, samples)");
  require(traces.shape(1) >= 32, "expected 32 samples or more");
  TimeZeroTracker tracker(period, max_delay);
  py::array_t<double> delays(traces.shape(0));
  double* delay = delays.mutable_data();
  py::array_t<float> aligned = each_trace<float>(
      traces, [&](const float* x, int n, float* out) { *delay++ = tracker.align(x, n, out); });
  return {aligned, delays};
}

py::array_t<std::int8_t> check_traces(const Floats& traces) {
  require_shape(traces, 2, "(traces, samples)");
  require(traces.shape(1) >= 8, "expected 8 samples or more");
  TraceCheck check;
  py::array_t<std::int8_t> quality(traces.shape(0));
  for (py::ssize_t i = 0; i < traces.shape(0); ++i) {
    quality.mutable_data()[i] = static_cast<std::int8_t>(
        check.check(traces.data() + i * traces.shape(1), static_cast<int>(traces.shape(1))));
  }
  return quality;
}

std::tuple<py::array_t<double>, py::array_t<double>> swt(const Doubles& trace,
                                                         const std::string& wavelet, int levels) {
  require_shape(trace, 1, "(samples,)");
  const py::ssize_t n = trace.size();
  StationaryWavelet<double> transform(
      make_wavelet(choice_argument<WaveletKind>("wavelet", wavelet)), levels);
  py::array_t<double> details({static_cast<py::ssize_t>(levels), n}), approximation(n);
  transform.forward(trace.data(), static_cast<int>(n), details.mutable_data(),
                    approximation.mutable_data());
  return {details, approximation};
}

py::array_t<double> iswt(const Doubles& details, const Doubles& approximation,
                         const std::string& wavelet) {
  require_shape(details, 2, "(levels, samples)");
  require_shape(approximation, 1, "(samples,)");
  const py::ssize_t n = approximation.size();
  require(details.shape(1) == n, "details and approximation must have the same number of samples");
  StationaryWavelet<double> transform(
      make_wavelet(choice_argument<WaveletKind>("wavelet", wavelet)),
      static_cast<int>(details.shape(0)));
  py::array_t<double> trace(n);
  transform.inverse(details.data(), approximation.data(), static_cast<int>(n),
                    trace.mutable_data());
  return trace;
}

py::array_t<double> keep_details(const Doubles& traces, const std::string& wavelet, int levels,
                                 double threshold) {
  DetailDenoiser<double> denoiser(make_wavelet(choice_argument<WaveletKind>("wavelet", wavelet)),
                                  levels, threshold);
  return each_trace<double>(
      traces, [&denoiser](const double* x, int n, double* out) { denoiser.apply(x, n, out); });
}

// Filtered traces (NaN where bad), quality, delay and noise of each.
std::tuple<py::array_t<float>, py::array_t<std::int8_t>, py::array_t<double>, py::array_t<double>>
retain_details(DetailsRetention& filter, const Floats& traces, double sample_interval,
               bool standing) {
  require_shape(traces, 2, "(traces, samples)");
  py::array_t<std::int8_t> quality(traces.shape(0));
  py::array_t<double> delay(traces.shape(0)), noise(traces.shape(0));
  py::ssize_t i = 0;
  py::array_t<float> out = each_trace<float>(traces, [&](const float* x, int n, float* y) {
    const DetailsRetention::Result result = filter.filter(x, n, sample_interval, standing);
    quality.mutable_data()[i] = static_cast<std::int8_t>(result.quality);
    delay.mutable_data()[i] = result.delay;
    noise.mutable_data()[i] = result.noise;
    ++i;
    if (result.samples != nullptr) {
      std::copy_n(result.samples, n, y);
    } else {
      std::fill_n(y, n, std::numeric_limits<float>::quiet_NaN());
    }
  });
  return {out, quality, delay, noise};
}

// The findings of a front end on traces, driven as the estimator drives it.
std::vector<Finding> findings(FrontEnd& front_end, const Times& times, const Floats& traces,
                              double sample_interval, double tick) {
  require_shape(traces, 2, "(traces, samples)");
  require(times.ndim() == 1 && times.shape(0) == traces.shape(0),
          "times: expected one stamp per trace");
  require(tick > 0.0, "tick: expected seconds above 0");
  std::vector<Finding> all;
  const TimeNs step = from_seconds(tick);
  TimeNs next = 0;
  GprTrace trace;
  trace.sample_interval_s = sample_interval;
  for (py::ssize_t i = 0; i <= traces.shape(0) && traces.shape(0) > 0; ++i) {
    const bool end = i == traces.shape(0);
    const TimeNs time = end ? next + 1 : times.data()[i];
    if (i == 0) next = time + step;
    for (; next < time; next += step) {
      for (Finding& finding : front_end.tick(next)) all.push_back(std::move(finding));
    }
    if (end) break;
    trace.time = time;
    trace.samples.assign(traces.data() + i * traces.shape(1),
                         traces.data() + (i + 1) * traces.shape(1));
    front_end.add_trace(trace);
  }
  return all;
}

// from, to of each claim of the stationarity front end.
py::array_t<std::int64_t> standstills(const Times& times, const Floats& traces,
                                      double sample_interval, double window, double tick) {
  require(window > 0.0, "window: expected seconds above 0");
  StationarityFrontEnd front_end(window);
  std::vector<std::int64_t> spans;
  for (const Finding& finding : findings(front_end, times, traces, sample_interval, tick)) {
    const auto* standstill = std::get_if<Standstill>(&finding);
    if (!standstill) continue;
    spans.push_back(standstill->from);
    spans.push_back(standstill->to);
  }
  py::array_t<std::int64_t> out({static_cast<py::ssize_t>(spans.size() / 2), py::ssize_t(2)});
  std::copy(spans.begin(), spans.end(), out.mutable_data());
  return out;
}

// from, to (ns), length and validity of each path by coherence.
using Paths = std::vector<std::tuple<std::int64_t, std::int64_t, double, bool>>;

Paths coherence(const Times& times, const Floats& traces, double sample_interval, double tick) {
  CoherenceFrontEnd front_end{GprConfig()};
  Paths paths;
  for (const Finding& finding : findings(front_end, times, traces, sample_interval, tick))
    if (const auto* path = std::get_if<PathLength>(&finding))
      paths.emplace_back(path->from, path->to, path->lengths, path->valid);
  return paths;
}

void bind_steps(py::module_& module) {
  module.def("design_band_pass", &design_band_pass, "low_hz"_a, "high_hz"_a, "sample_interval"_a,
             "length"_a,
             "Taps of the triangular-window band-pass of about `length` seconds; run both ways by "
             "band_pass.");
  module.def("band_pass", &band_pass, "traces"_a, "sample_interval"_a, "low_hz"_a = 1.5e8,
             "high_hz"_a = 9.0e8, "length"_a = 1e-8,
             "Zero-phase band-pass along each trace (..., samples).");
  module.def("dewow", &dewow_traces, "traces"_a, "half_width"_a,
             "Each trace (..., samples) less its mean over 2 half_width + 1 samples.");
  module.def("gain_curve", &gain_curve, "samples"_a, "rate"_a, "power"_a, "flat_after"_a,
             "max(i, 1)^power exp(rate i) for sample i, constant from flat_after on.");
  module.def("remove_background", &remove_background, "traces"_a, "mode"_a = "sequence",
             "memory"_a = 400,
             "Traces (traces, samples) less their mean. mode: mean of the whole 'sequence'; "
             "'running' mean with exponential forgetting over `memory` traces; or mean of the "
             "'window' of the last `memory` traces.");
  module.def("track_time_zero", &track_time_zero, "traces"_a, "period"_a, "max_delay"_a,
             "Traces (traces, samples) aligned on the direct wave, and the delay removed from "
             "each, samples. period: of the antenna's centre frequency, samples.");
  module.def("check_traces", &check_traces, "traces"_a,
             "For each of (traces, samples): 0 good, 1 dead, 2 spiked.");
}

void bind_wavelet(py::module_& module) {
  module.def("swt", &swt, "trace"_a, "wavelet"_a, "levels"_a,
             "Stationary wavelet transform of (samples,), a multiple of 2^levels: details "
             "(levels, samples), finest first, and the last approximation (samples,).");
  module.def("iswt", &iswt, "details"_a, "approximation"_a, "wavelet"_a, "The inverse of swt.");
  module.def("keep_details", &keep_details, "traces"_a, "wavelet"_a = "sym4", "levels"_a = 4,
             "threshold"_a = 1.0,
             "Each trace (..., samples) with its approximation zeroed and its details "
             "soft-thresholded at threshold * sigma * sqrt(2 ln samples), sigma from the median "
             "absolute finest detail.");
}

}  // namespace

void bind_gpr_filter(py::module_& module) {
  bind_steps(module);
  bind_wavelet(module);
  py::class_<FilterOptions> config(module, "FilterConfig",
                                   "Options of DetailsRetention: the keys gpr.filter.* of the "
                                   "configuration and what is fixed there.");
  def_choice(config, "background", &FilterOptions::background);
  def_choice(config, "wavelet", &FilterOptions::wavelet);
  config.def(py::init<>())
      .def_readwrite("dewow_window", &FilterOptions::dewow_window)
      .def_readwrite("time_zero_max", &FilterOptions::time_zero_max)
      .def_readwrite("background_memory", &FilterOptions::background_memory)
      .def_readwrite("wavelet_levels", &FilterOptions::wavelet_levels)
      .def_readwrite("wavelet_threshold", &FilterOptions::wavelet_threshold)
      .def_readwrite("band_low", &FilterOptions::band_low)
      .def_readwrite("band_high", &FilterOptions::band_high)
      .def_readwrite("band_length", &FilterOptions::band_length)
      .def_readwrite("gain_rate", &FilterOptions::gain_rate)
      .def_readwrite("gain_power", &FilterOptions::gain_power)
      .def_readwrite("gain_flat_after", &FilterOptions::gain_flat_after);
  py::class_<DetailsRetention>(module, "DetailsRetention",
                               "Details retention on a stream of traces, as the radar front ends "
                               "run it.")
      .def(py::init<const FilterOptions&>(), py::arg_v("config", FilterOptions(), "FilterConfig()"))
      .def("filter", &retain_details, "traces"_a, "sample_interval"_a, "standing"_a = false,
           "Takes in (traces, samples), oldest first; returns the filtered traces (float32, NaN "
           "where bad), and for each its quality (0 good, 1 dead, 2 spiked), the removed delay "
           "(samples) and the measured noise (counts).")
      .def("reset", &DetailsRetention::reset, "Forgets all traces.");
  module.def("standstills", &standstills, "times"_a, "traces"_a, "sample_interval"_a,
             "window"_a = StationarityFrontEnd::kWindow, "tick"_a = GprConfig().tick,
             "Standstills that the stationarity front end detects in (traces, samples) at `times` "
             "(ns): (n, 2), begin and end of each, ns. They overlap.");
  module.def("coherence", &coherence, "times"_a, "traces"_a, "sample_interval"_a,
             "tick"_a = GprConfig().tick,
             "Path lengths that the coherence front end measures in (traces, samples) at `times` "
             "(ns): begin and end of each, ns; its length in decorrelation lengths of the ground; "
             "whether that is valid.");
}
