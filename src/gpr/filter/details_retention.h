// Details retention on a stream of traces: segmentation of the background, decomposition in
// frequency, preservation and restoration of the details. The paper's method is not published in
// detail; this is a substitute made of well-known steps.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "gpr/filter/background.h"
#include "gpr/filter/band_pass.h"
#include "gpr/filter/time_zero.h"
#include "gpr/filter/trace_quality.h"
#include "gpr/filter/wavelet.h"
#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

// In order, each step optional (GprFilterConfig):
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
  explicit DetailsRetention(const GprFilterConfig& config);

  // standing: the antenna does not move, so the trace gets little weight in the background.
  // Throws std::invalid_argument where the band does not fit the sample interval.
  Result filter(const float* samples, int n, double sample_interval_s, bool standing = false);
  Result filter(const GprTrace& trace, bool standing = false);

  // Forgets all traces.
  void reset();

 private:
  void prepare(int n, double sample_interval_s);

  GprFilterConfig config_;
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
