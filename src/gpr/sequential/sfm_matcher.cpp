// Feature matrix against feature matrix (front end sfm).
#include <array>
#include <utility>

#include "gpr/peaks/peaks.h"
#include "gpr/sequential/window_matcher.h"

namespace gprodom::gpr {

namespace {

constexpr std::size_t kMaxTracePeaks = 64;

// Overlapping pulses fitted together. On ground they are better fitted each by itself: a
// band-passed pulse does not decay as the model does, and its tail would disturb the next
// (docs/sfm.md).
constexpr int kMaxJoint = 1;

// s from the start that fix the amplitude scale of the levels. The paper's scale is the greatest
// peak, of which it does not say when it is known; a scale per window would change the levels of
// equal echoes.
constexpr double kScaleDuration = 20.0;

// The peaks of one trace: depth (m) and amplitude, positions are those of the trace in the window.
struct TracePeaks {
  std::size_t count = 0;
  std::array<std::pair<double, double>, kMaxTracePeaks> depth_and_amplitude;
};

PeakOptions peak_options(bool fit) {
  PeakOptions options;
  options.fit = fit;
  options.max_joint = kMaxJoint;
  return options;
}

class SfmMatcher : public FeatureMatcher {
 public:
  explicit SfmMatcher(const GprConfig& config)
      : FeatureMatcher(config.sequential),
        wave_speed_(config.wave_speed),
        ring_(static_cast<std::size_t>(config.sequential.window_traces)),
        extractor_(peak_options(config.peaks.fit)) {
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
    if (trace.time_s >= kScaleDuration) scale_.fix();
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
    return match(depth_range_, *scale_.value());
  }

  void reset() override {
    FeatureMatcher::reset();
    ring_.clear();
    scale_.reset();
    depth_range_ = 0.0;
  }

 private:
  double depth_range(const WindowTrace& trace) const {
    return depth_of(
        travel_time(static_cast<double>(trace.count), trace.sample_interval_s, trace.time_zero_s),
        wave_speed_);
  }

  double wave_speed_;
  double depth_range_ = 0.0;  // D, m; 0 until the first trace
  Ring<TracePeaks> ring_;
  PeakExtractor extractor_;
  AmplitudeScale scale_;
};

}  // namespace

std::unique_ptr<WindowMatcher> make_sfm_matcher(const GprConfig& config) {
  return std::make_unique<SfmMatcher>(config);
}

}  // namespace gprodom::gpr
