#include "gpr/window_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "gprodom/error.h"
#include "gprodom/gpr/dec.h"
#include "gprodom/gpr/peaks.h"

namespace gprodom::gpr {

namespace {

AlignmentOptions alignment_options(const SequentialConfig& config) {
  AlignmentOptions options;
  options.form = config.distance == "printed" ? DistanceForm::kPrinted : DistanceForm::kCosine;
  options.min_overlap = config.min_overlap;
  return options;
}

// From the columns of a window of `length` columns to those of the SFM grid.
Alignment in_grid_columns(Alignment alignment, double columns_per_trace) {
  alignment.shift = static_cast<int>(std::lround(alignment.shift * columns_per_trace));
  alignment.subcolumn *= columns_per_trace;
  alignment.variance *= columns_per_trace * columns_per_trace;
  alignment.overlap = static_cast<int>(std::lround(alignment.overlap * columns_per_trace));
  return alignment;
}

double columns_per_trace(const SequentialConfig& config) {
  return static_cast<double>(config.columns) / config.window_traces;
}

constexpr std::size_t kMaxTracePeaks = 64;

// The peaks of one trace: depth (m) and amplitude, positions are those of the trace in the window.
struct TracePeaks {
  std::size_t count = 0;
  std::array<std::pair<double, double>, kMaxTracePeaks> depth_and_amplitude;
};

PeakOptions peak_options(const PeaksConfig& config) {
  PeakOptions options;
  options.fit = config.fit;
  options.min_snr = config.min_snr;
  options.min_relative = config.min_relative;
  options.max_joint = config.max_joint;
  options.max_residual = config.max_residual;
  return options;
}

class SfmMatcher : public WindowMatcher {
 public:
  explicit SfmMatcher(const GprConfig& config)
      : config_(config.sequential),
        wave_speed_(config.wave_speed),
        ring_(static_cast<std::size_t>(config.sequential.window_traces)),
        extractor_(peak_options(config.peaks)),
        scale_(config.sequential.scale_quantile),
        aligner_(alignment_options(config.sequential)) {
    points_.reserve(ring_.capacity() * kMaxTracePeaks);
  }

  void add(const WindowTrace& trace) override {
    TracePeaks& place = ring_.place();
    place.count = 0;
    if (trace.filtered == nullptr) return;
    if (depth_range_ == 0.0) depth_range_ = depth_range(trace);
    for (const Peak& peak : extractor_.extract(trace.filtered, trace.count)) {
      const double depth = depth_of(
          travel_time(peak.sample, trace.sample_interval_s, trace.time_zero_s), wave_speed_);
      if (depth < 0.0 || depth >= depth_range_ || place.count == kMaxTracePeaks) continue;
      place.depth_and_amplitude[place.count++] = {depth, peak.amplitude};
      scale_.collect(peak.amplitude);
    }
    if (trace.time_s >= config_.scale_duration) scale_.fix();
  }

  std::optional<Alignment> advance() override {
    if (!ring_.full()) return std::nullopt;
    if (!scale_.value()) return Alignment();
    points_.clear();
    for (std::size_t r = 0; r < ring_.capacity(); ++r) {
      const TracePeaks& peaks = ring_[r];
      for (std::size_t i = 0; i < peaks.count; ++i) {
        const auto& [depth, amplitude] = peaks.depth_and_amplitude[i];
        points_.push_back({depth, static_cast<double>(r), amplitude});
      }
    }
    std::swap(before_, levels_);
    build_sfm(points_.data(), points_.size(),
              {config_.rows, config_.columns, depth_range_,
               static_cast<double>(config_.window_traces), *scale_.value()},
              levels_);
    if (before_.size() != levels_.size()) return Alignment();  // the first matrix
    return aligner_.align(before_, levels_);
  }

  const LevelMatrix* levels() const override { return levels_.size() > 0 ? &levels_ : nullptr; }

  void reset() override {
    ring_.clear();
    scale_.reset();
    before_.resize(0, 0);
    levels_.resize(0, 0);
    depth_range_ = 0.0;
  }

 private:
  double depth_range(const WindowTrace& trace) const {
    if (config_.max_depth > 0.0) return config_.max_depth;
    return depth_of(
        travel_time(static_cast<double>(trace.count), trace.sample_interval_s, trace.time_zero_s),
        wave_speed_);
  }

  SequentialConfig config_;
  double wave_speed_;
  double depth_range_ = 0.0;  // D, m; 0 until the first trace
  Ring<TracePeaks> ring_;
  PeakExtractor extractor_;
  AmplitudeScale scale_;
  Aligner aligner_;
  std::vector<FeaturePoint> points_;
  LevelMatrix before_, levels_;
};

// The B-scan as it is recorded, less the window's mean trace: without that the direct wave, equal
// in all traces, would make every shift a perfect match.
class BscanMatcher : public WindowMatcher {
 public:
  explicit BscanMatcher(const GprConfig& config)
      : columns_per_trace_(columns_per_trace(config.sequential)),
        ring_(static_cast<std::size_t>(config.sequential.window_traces)),
        aligner_(alignment_options(config.sequential)) {}

  void add(const WindowTrace& trace) override {
    std::vector<float>& place = ring_.place();
    if (trace.raw == nullptr) {
      place.clear();
      return;
    }
    place.assign(trace.raw, trace.raw + trace.count);
    samples_ = trace.count;
  }

  std::optional<Alignment> advance() override {
    if (!ring_.full() || samples_ == 0) return std::nullopt;
    fill_window();
    std::optional<Alignment> result;
    if (before_.size() == window_.size()) {
      result = in_grid_columns(aligner_.align(before_, window_), columns_per_trace_);
    }
    std::swap(before_, window_);
    return result;
  }

  void reset() override {
    ring_.clear();
    before_.resize(0, 0);
    samples_ = 0;
  }

 private:
  void fill_window() {
    const auto samples = static_cast<Eigen::Index>(samples_);
    window_.setZero(samples, static_cast<Eigen::Index>(ring_.capacity()));
    mean_.setZero(samples);
    int used = 0;
    for (std::size_t c = 0; c < ring_.capacity(); ++c) {
      if (ring_[c].size() != samples_) continue;
      window_.col(static_cast<Eigen::Index>(c)) =
          Eigen::Map<const Eigen::VectorXf>(ring_[c].data(), samples);
      mean_ += window_.col(static_cast<Eigen::Index>(c));
      ++used;
    }
    if (used == 0) return;
    mean_ /= static_cast<float>(used);
    for (std::size_t c = 0; c < ring_.capacity(); ++c) {
      if (ring_[c].size() == samples_) window_.col(static_cast<Eigen::Index>(c)) -= mean_;
    }
  }

  double columns_per_trace_;
  Ring<std::vector<float>> ring_;  // empty where a trace was bad
  Aligner aligner_;
  Eigen::MatrixXf before_, window_;
  Eigen::VectorXf mean_;
  std::size_t samples_ = 0;
};

class DecMatcher : public WindowMatcher {
 public:
  explicit DecMatcher(const GprConfig& config)
      : config_(config.dec),
        columns_per_trace_(columns_per_trace(config.sequential)),
        ring_(static_cast<std::size_t>(config.sequential.window_traces)),
        columns_(ring_.capacity()),
        refiner_({config.dec.jump_penalty, config.dec.smoothing}),
        aligner_(alignment_options(config.sequential)) {}

  void add(const WindowTrace& trace) override {
    EnergyPoints& place = ring_.place();
    place.count = 0;
    if (trace.filtered == nullptr) return;
    energy_.resize(trace.count);
    const double half = 0.5 * config_.energy_window / trace.sample_interval_s;
    trace_energy(trace.filtered, trace.count, std::max(1, static_cast<int>(std::lround(half))),
                 energy_.data());
    const auto first_row = static_cast<std::size_t>(
        std::max(0.0, (config_.first_time + trace.time_zero_s) / trace.sample_interval_s));
    if (first_row + 3 > trace.count) return;
    const double threshold =
        background_threshold(energy_.data() + first_row, trace.count - first_row);
    place = energy_points(energy_.data(), trace.count, static_cast<int>(first_row), threshold);
  }

  std::optional<Alignment> advance() override {
    if (!ring_.full()) return std::nullopt;
    for (std::size_t c = 0; c < columns_.size(); ++c) columns_[c] = ring_[c];
    refiner_.refine(columns_, curve_);
    std::optional<Alignment> result;
    if (before_.size() == curve_.size()) {
      result = in_grid_columns(aligner_.align(before_, curve_), columns_per_trace_);
    }
    std::swap(before_, curve_);
    return result;
  }

  void reset() override {
    ring_.clear();
    before_.resize(0);
  }

 private:
  DecConfig config_;
  double columns_per_trace_;
  Ring<EnergyPoints> ring_;
  std::vector<EnergyPoints> columns_;
  std::vector<float> energy_;
  CurveRefiner refiner_;
  CurveAligner aligner_;
  Eigen::VectorXd before_, curve_;
};

// Knows nothing but how many traces came: what the other methods are to be measured against.
class TraceCountMatcher : public WindowMatcher {
 public:
  explicit TraceCountMatcher(const GprConfig& config)
      : columns_per_trace_(columns_per_trace(config.sequential)) {}

  void add(const WindowTrace&) override { ++count_; }

  std::optional<Alignment> advance() override {
    Alignment alignment;
    alignment.valid = true;
    alignment.subcolumn = -count_ * columns_per_trace_;
    alignment.shift = static_cast<int>(std::lround(alignment.subcolumn));
    alignment.variance = columns_per_trace_ * columns_per_trace_ / 12.0;  // a trace more or less
    const bool first = !started_;
    started_ = true;
    count_ = 0;
    if (first) return std::nullopt;
    return alignment;
  }

  void reset() override {
    count_ = 0;
    started_ = false;
  }

 private:
  double columns_per_trace_;
  int count_ = 0;
  bool started_ = false;
};

}  // namespace

std::unique_ptr<WindowMatcher> make_window_matcher(const GprConfig& config) {
  if (config.front_end == "sfm") return std::make_unique<SfmMatcher>(config);
  if (config.front_end == "bscan") return std::make_unique<BscanMatcher>(config);
  if (config.front_end == "dec") return std::make_unique<DecMatcher>(config);
  if (config.front_end == "trace_count") return std::make_unique<TraceCountMatcher>(config);
  throw ConfigError("gpr.front_end: " + config.front_end +
                    " compares no windows; expected sfm, bscan, dec or trace_count");
}

}  // namespace gprodom::gpr
