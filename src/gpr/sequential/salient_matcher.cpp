// Salient regions against salient regions (front end salient).
#include <algorithm>
#include <cmath>

#include "gpr/sequential/apexes.h"
#include "gpr/sequential/window_matcher.h"

namespace gprodom::gpr {
namespace {

// The apexes of a window as a feature matrix, so that they are matched as the paper's are: each in
// the cell of its travel time and trace. All have one level: which are strong changes as they enter
// and leave.
class SalientMatcher : public FeatureMatcher {
 public:
  explicit SalientMatcher(const GprConfig& config)
      : FeatureMatcher(config.sequential), traces_(config.sequential.window_traces) {
    options_.pulse_s = kPeriods * 2.0 / (config.filter.band_low + config.filter.band_high);
  }

  void add(const WindowTrace& trace) override {
    traces_.add(trace.filtered, trace.count);
    if (trace.filtered == nullptr) return;
    options_.sample_interval_s = trace.sample_interval_s;
    options_.time_zero_s = trace.time_zero_s;
    if (trace.time_zero_s != 0.0) return;
    // Not known: the direct wave's maximum.
    const float* largest =
        std::max_element(trace.raw, trace.raw + trace.count,
                         [](float a, float b) { return std::abs(a) < std::abs(b); });
    options_.time_zero_s = static_cast<double>(largest - trace.raw) * trace.sample_interval_s;
  }

  std::optional<Alignment> advance() override {
    if (!traces_.full()) return std::nullopt;
    traces_.fill(window_);
    points_.clear();
    for (const Apex& apex : find_apexes(window_, options_))
      points_.push_back({apex.time_s, apex.column, 1.0});
    return match(static_cast<double>(window_.rows()) * options_.sample_interval_s, 1.0);
  }

  void reset() override {
    FeatureMatcher::reset();
    traces_.clear();
  }

 private:
  static constexpr double kPeriods = 1.5;  // of the band's middle in an echo

  TraceColumns traces_;
  ApexOptions options_;
  Eigen::MatrixXf window_;
};

}  // namespace

std::unique_ptr<WindowMatcher> make_salient_matcher(const GprConfig& config) {
  return std::make_unique<SalientMatcher>(config);
}

}  // namespace gprodom::gpr
