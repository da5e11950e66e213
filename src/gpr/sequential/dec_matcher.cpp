// Dominant energy curve against curve (front end dec).
#include <algorithm>
#include <cmath>

#include "gpr/sequential/dec.h"
#include "gpr/sequential/window_matcher.h"

namespace gprodom::gpr {

namespace {

// s of a trace over which energy is averaged: a period of the antenna.
constexpr double kEnergyWindow = 2.0e-9;
// s after time zero. Earlier is the direct wave, which is stronger than any echo.
constexpr double kFirstTime = 4.0e-9;

class DecMatcher : public WindowMatcher {
 public:
  explicit DecMatcher(const GprConfig& config)
      : columns_per_trace_(columns_per_trace(config.sequential)),
        ring_(static_cast<std::size_t>(config.sequential.window_traces)),
        columns_(ring_.capacity()),
        aligner_(alignment_options(config.sequential)) {}

  void add(const WindowTrace& trace) override {
    EnergyPoints& place = ring_.place();
    place.count = 0;
    if (trace.filtered == nullptr) return;
    energy_.resize(trace.count);
    const double half = 0.5 * kEnergyWindow / trace.sample_interval_s;
    trace_energy(trace.filtered, trace.count, std::max(1, static_cast<int>(std::lround(half))),
                 energy_.data());
    const auto first_row = static_cast<std::size_t>(
        std::max(0.0, (kFirstTime + trace.time_zero_s) / trace.sample_interval_s));
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
  double columns_per_trace_;
  Ring<EnergyPoints> ring_;
  std::vector<EnergyPoints> columns_;
  std::vector<float> energy_;
  CurveRefiner refiner_;
  CurveAligner aligner_;
  Eigen::VectorXd before_, curve_;
};

}  // namespace

std::unique_ptr<WindowMatcher> make_dec_matcher(const GprConfig& config) {
  return std::make_unique<DecMatcher>(config);
}

}  // namespace gprodom::gpr
