// Salient regions against salient regions (front end salient).
#include <algorithm>
#include <utility>

#include "gpr/sequential/apexes.h"
#include "gpr/sequential/window_matcher.h"

namespace gprodom::gpr {
namespace {

// The apexes of a window as a feature matrix, so that they are matched as the paper's are: each in
// the cell of its travel time and trace. All have one level: which are strong changes as they enter
// and leave.
class SalientMatcher : public WindowMatcher {
 public:
  explicit SalientMatcher(const GprConfig& config)
      : config_(config.sequential),
        pulse_s_(kPeriods * 2.0 / (config.filter.band_low + config.filter.band_high)),
        ring_(static_cast<std::size_t>(config.sequential.window_traces)),
        aligner_(alignment_options(config.sequential)) {}

  void add(const WindowTrace& trace) override {
    std::vector<float>& place = ring_.place();
    if (trace.filtered == nullptr) {
      place.clear();
      return;
    }
    place.assign(trace.filtered, trace.filtered + trace.count);
    options_.sample_interval_s = trace.sample_interval_s;
    options_.time_zero_s = trace.time_zero_s;
    if (trace.time_zero_s == 0.0) {  // not known: the direct wave's maximum
      Eigen::Index row = 0;
      Eigen::Map<const Eigen::VectorXf>(trace.raw, static_cast<Eigen::Index>(trace.count))
          .cwiseAbs()
          .maxCoeff(&row);
      options_.time_zero_s = static_cast<double>(row) * trace.sample_interval_s;
    }
  }

  std::optional<Alignment> advance() override {
    if (!ring_.full() || options_.sample_interval_s == 0.0) return std::nullopt;  // no good trace
    fill_window();
    options_.pulse_s = pulse_s_;
    const std::vector<Apex> apexes = find_apexes(window_, options_);
    points_.clear();
    points_.reserve(apexes.size());
    for (const Apex& apex : apexes) points_.push_back({apex.time_s, apex.column, 1.0});
    std::swap(before_, levels_);
    build_sfm(points_.data(), points_.size(),
              {config_.rows, config_.columns,
               static_cast<double>(window_.rows()) * options_.sample_interval_s,
               static_cast<double>(config_.window_traces), 1.0},
              levels_);
    if (before_.size() != levels_.size()) return Alignment();  // the first matrix
    return aligner_.align(before_, levels_);
  }

  const LevelMatrix* levels() const override { return levels_.size() > 0 ? &levels_ : nullptr; }

  void reset() override {
    ring_.clear();
    options_ = {};
    before_.resize(0, 0);
    levels_.resize(0, 0);
  }

 private:
  static constexpr double kPeriods = 1.5;  // of the band's middle in an echo

  // A bad trace is a column of zeros, which explains nothing.
  void fill_window() {
    std::size_t samples = 0;
    for (std::size_t c = 0; c < ring_.capacity(); ++c) samples = std::max(samples, ring_[c].size());
    window_.setZero(static_cast<Eigen::Index>(samples),
                    static_cast<Eigen::Index>(ring_.capacity()));
    for (std::size_t c = 0; c < ring_.capacity(); ++c) {
      if (ring_[c].size() != samples) continue;
      window_.col(static_cast<Eigen::Index>(c)) =
          Eigen::Map<const Eigen::VectorXf>(ring_[c].data(), static_cast<Eigen::Index>(samples));
    }
  }

  SequentialConfig config_;
  double pulse_s_;
  Ring<std::vector<float>> ring_;  // empty where a trace was bad
  ApexOptions options_;
  Eigen::MatrixXf window_;
  std::vector<FeaturePoint> points_;
  Aligner aligner_;
  LevelMatrix before_, levels_;
};

}  // namespace

std::unique_ptr<WindowMatcher> make_salient_matcher(const GprConfig& config) {
  return std::make_unique<SalientMatcher>(config);
}

}  // namespace gprodom::gpr
