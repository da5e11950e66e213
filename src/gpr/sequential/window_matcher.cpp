#include "gpr/sequential/window_matcher.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace gprodom::gpr {

AlignmentOptions alignment_options(const SequentialConfig& config) {
  AlignmentOptions options;
  options.form = config.distance;
  return options;
}

double columns_per_trace(const SequentialConfig& config) {
  return static_cast<double>(config.columns) / config.window_traces;
}

Alignment in_grid_columns(Alignment alignment, double columns_per_trace) {
  alignment.shift = static_cast<int>(std::lround(alignment.shift * columns_per_trace));
  alignment.subcolumn *= columns_per_trace;
  alignment.variance *= columns_per_trace * columns_per_trace;
  alignment.overlap = static_cast<int>(std::lround(alignment.overlap * columns_per_trace));
  return alignment;
}

void TraceColumns::add(const float* samples, std::size_t count) {
  std::vector<float>& place = ring_.place();
  place.assign(samples, samples == nullptr ? samples : samples + count);
  if (!place.empty()) samples_ = count;
}

void TraceColumns::fill(Eigen::MatrixXf& bscan) const {
  const auto samples = static_cast<Eigen::Index>(samples_);
  bscan.setZero(samples, static_cast<Eigen::Index>(ring_.capacity()));
  for (std::size_t c = 0; c < ring_.capacity(); ++c) {
    if (!good(c)) continue;
    bscan.col(static_cast<Eigen::Index>(c)) =
        Eigen::Map<const Eigen::VectorXf>(ring_[c].data(), samples);
  }
}

void TraceColumns::clear() {
  ring_.clear();
  samples_ = 0;
}

FeatureMatcher::FeatureMatcher(const SequentialConfig& config)
    : aligner_(alignment_options(config)) {
  grid_.rows = config.rows;
  grid_.columns = config.columns;
  grid_.length = static_cast<double>(config.window_traces);
}

Alignment FeatureMatcher::match(double depth_range, double amplitude_scale) {
  grid_.depth_range = depth_range;
  grid_.amplitude_scale = amplitude_scale;
  std::swap(before_, levels_);
  build_sfm(points_.data(), points_.size(), grid_, levels_);
  if (before_.size() != levels_.size()) return {};  // the first matrix
  return aligner_.align(before_, levels_);
}

void FeatureMatcher::reset() {
  before_.resize(0, 0);
  levels_.resize(0, 0);
}

namespace {

// The trivial baseline: knows only how many traces came.
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
  switch (config.front_end) {
    case FrontEndKind::kSfm:
      return make_sfm_matcher(config);
    case FrontEndKind::kBscan:
      return make_bscan_matcher(config);
    case FrontEndKind::kDec:
      return make_dec_matcher(config);
    case FrontEndKind::kSalient:
      return make_salient_matcher(config);
    case FrontEndKind::kTraceCount:
      return std::make_unique<TraceCountMatcher>(config);
    default:
      throw std::invalid_argument(
          "gpr.front_end: " + name_of(config.front_end) +
          " compares no windows; expected sfm, bscan, dec, salient or trace_count");
  }
}

}  // namespace gprodom::gpr
