// Details retention on a stream of traces: segmentation of the background, decomposition in
// frequency, preservation and restoration of the details. The paper's method is not published in
// detail; this is a substitute made of well-known steps.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "gpr/filter/background.h"
#include "gpr/filter/band_pass.h"
#include "gpr/filter/time_zero.h"
#include "gpr/filter/trace_quality.h"
#include "gpr/filter/wavelet.h"
#include "gprodom/choices.h"
#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

enum class Background { kRunning, kWindow, kNone };
constexpr std::array<const char*, 3> names_like(Background) {
  return {"running", "window", "none"};
}
static_assert(names_like(Background{}).size() == std::size_t(Background::kNone) + 1);

// Band and gain are the antenna's, and are set. The rest is the same for every antenna.
struct FilterOptions : GprFilterConfig {
  FilterOptions() = default;
  explicit FilterOptions(const GprFilterConfig& config) : GprFilterConfig(config) {}

  // s of the band-pass, which is run both ways: one and a half periods at the usual lower edge of
  // the band. A longer one has steeper edges, and spreads an echo further.
  static constexpr double kBandLength = 1.0e-8;

  double dewow_window = 8e-9;   // s of the running mean that is taken out: longer than any period
                                // in the band; 0: none
  double time_zero_max = 1e-9;  // s by which a trace may start early or late, half a period of the
                                // antenna; 0: not tracked
  Background background = Background::kRunning;
  int background_memory = 400;  // traces: some metres of ground, over which echoes average out
  WaveletKind wavelet = WaveletKind::kSym4;  // nearly symmetric, and about as long as the pulse
  int wavelet_levels = 4;  // the approximation of the last is zeroed: it lies below the band
  double wavelet_threshold = 1.0;  // of noise sigma sqrt(2 ln n), which white noise rarely exceeds
  double band_length = kBandLength;  // 0: no band-pass
};

// In order, each step optional (FilterOptions):
//   check       dead and spiked traces are flagged and go no further
//   dewow       the receiver's slow offset
//   time zero   the direct wave to the same sample in each trace
//   background  the mean trace
//   wavelet     approximation zeroed, details soft-thresholded: while the noise is still white, so
//               that the finest details give its level
//   band-pass   the antenna's band, zero-phase
//   gain        over travel time
// One trace in, one trace out, without looking ahead. No allocation after the first good trace of a
// length and sample interval.
class DetailsRetention {
 public:
  struct Result {
    TraceQuality quality = TraceQuality::kGood;
    double delay = 0.0;  // samples, removed by the time-zero step
    double noise = 0.0;  // counts: standard deviation of the noise that the wavelet step found
    // The filtered trace, counts, of the length put in; valid until the next call. nullptr unless
    // quality is kGood.
    const float* samples = nullptr;
  };

  // Throws std::invalid_argument on settings that contradict each other.
  // Throws ConfigError where the band's edges are not in order.
  explicit DetailsRetention(const FilterOptions& options);
  explicit DetailsRetention(const GprFilterConfig& config)
      : DetailsRetention(FilterOptions(config)) {}

  // standing: the antenna does not move, so the trace gets little weight in the background.
  // Throws std::invalid_argument where the band does not fit the sample interval.
  Result filter(const float* samples, int n, double sample_interval_s, bool standing = false);
  Result filter(const GprTrace& trace, bool standing = false);

  // Forgets all traces.
  void reset();

 private:
  void prepare(int n, double sample_interval_s);

  FilterOptions options_;
  int n_ = 0;
  double sample_interval_ = 0.0;
  TraceCheck check_;
  std::optional<TimeZeroTracker> time_zero_;
  std::optional<RunningBackground> background_;
  std::optional<DetailDenoiser<float>> denoiser_;
  ZeroPhaseFilter<float> band_pass_;
  int dewow_half_width_ = 0;
  Eigen::VectorXf gain_;
  Eigen::VectorXf trace_, other_;
};

}  // namespace gprodom::gpr
