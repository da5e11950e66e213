#include "gpr/filter/details_retention.h"

#include <algorithm>
#include <cmath>

#include "base/require.h"
#include "gprodom/error.h"

namespace gprodom::gpr {
namespace {

constexpr float kStandingWeight = 0.02f;  // of a standing antenna's trace in the background

std::optional<RunningBackground> make_background(const FilterOptions& options) {
  if (options.background == Background::kNone) return std::nullopt;
  const auto mode = options.background == Background::kRunning ? RunningBackground::Mode::kRunning
                                                               : RunningBackground::Mode::kWindow;
  return RunningBackground(mode, options.background_memory);
}

std::optional<DetailDenoiser<float>> make_denoiser(const FilterOptions& options) {
  if (options.wavelet == WaveletKind::kNone) return std::nullopt;
  return DetailDenoiser<float>(make_wavelet(options.wavelet), options.wavelet_levels,
                               options.wavelet_threshold);
}

}  // namespace

DetailsRetention::DetailsRetention(const FilterOptions& options)
    : options_(options), background_(make_background(options)), denoiser_(make_denoiser(options)) {
  if (!(options.band_low < options.band_high))
    throw ConfigError("gpr.filter.band_low: expected less than gpr.filter.band_high");
}

void DetailsRetention::reset() {
  n_ = 0;
  check_.reset();
  if (background_) background_->reset();
}

// What depends on the sample interval and the length.
void DetailsRetention::prepare(int n, double sample_interval_s) {
  reset();
  require(sample_interval_s > 0.0, "radar traces: expected a sample interval above 0");
  const double low = options_.band_low, high = options_.band_high;
  if (options_.band_length > 0.0) {
    band_pass_ = ZeroPhaseFilter<float>(
        design_band_pass(low, high, sample_interval_s, options_.band_length));
  }
  time_zero_.reset();
  if (options_.time_zero_max > 0.0) {
    time_zero_.emplace(1.0 / (std::sqrt(low * high) * sample_interval_s),
                       options_.time_zero_max / sample_interval_s);
  }
  dewow_half_width_ =
      static_cast<int>(std::lround(0.5 * options_.dewow_window / sample_interval_s));
  const std::vector<double> gain =
      gain_curve(n, options_.gain_rate, options_.gain_power, options_.gain_flat_after);
  gain_ = Eigen::Map<const Eigen::VectorXd>(gain.data(), n).cast<float>();
  trace_.resize(n);
  other_.resize(n);
  n_ = n;
  sample_interval_ = sample_interval_s;
}

DetailsRetention::Result DetailsRetention::filter(const GprTrace& trace, bool standing) {
  return filter(trace.samples.data(), static_cast<int>(trace.samples.size()),
                trace.sample_interval_s, standing);
}

DetailsRetention::Result DetailsRetention::filter(const float* samples, int n,
                                                  double sample_interval_s, bool standing) {
  require(n >= 32, "radar traces: expected 32 samples or more");
  if (n != n_ || sample_interval_s != sample_interval_) prepare(n, sample_interval_s);
  Result result;
  result.quality = check_.check(samples, n);
  if (result.quality != TraceQuality::kGood) return result;

  const float weight = standing ? kStandingWeight : 1.0f;
  if (dewow_half_width_ > 0) {
    dewow(samples, n, dewow_half_width_, trace_.data());
  } else {
    std::copy_n(samples, n, trace_.data());
  }
  if (time_zero_) {
    result.delay = time_zero_->align(trace_.data(), n, other_.data());
    trace_.swap(other_);
  }
  if (background_) background_->remove(trace_.data(), n, weight);
  if (denoiser_) result.noise = denoiser_->apply(trace_.data(), n, trace_.data());
  if (options_.band_length > 0.0) band_pass_.apply(trace_.data(), n, trace_.data());
  trace_.array() *= gain_.array();
  result.samples = trace_.data();
  return result;
}

}  // namespace gprodom::gpr
