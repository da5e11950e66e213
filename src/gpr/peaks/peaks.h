// Reflections in one filtered trace: the damped-sinusoid fit of Li et al. (arXiv 2503.18301),
//     A'(i) = beta exp(-alpha i) cos(omega i + phi) + gamma,
// one sinusoid per pulse, fitted by least squares (the maximum likelihood under white noise). The
// peak is the first maximum of the fitted curve.
//
// Stages, each usable alone: analytic_signal (peaks_envelope.h), find_pulses (peaks_pulses.h),
// fit_pulses (peaks_varpro.h), peak_of_fit (peaks_covariance.h).
#pragma once

#include <cstddef>
#include <vector>

#include "gpr/peaks/peak.h"
#include "gpr/peaks/peaks_envelope.h"
#include "gpr/peaks/peaks_joint.h"
#include "gpr/peaks/peaks_pulses.h"

namespace gprodom::gpr {

// Keeps its buffers: no allocation from the second trace of one length on.
class PeakExtractor {
 public:
  // Throws std::invalid_argument on an option out of range.
  explicit PeakExtractor(const PeakOptions& options = {});

  // Peaks of a trace of `size` samples, background removed and band-passed, in order of time. The
  // result is valid until the next call. A trace with a value that is not finite has no peaks.
  const std::vector<Peak>& extract(const float* trace, std::size_t size);

  const PeakCounts& counts() const { return counts_; }

 private:
  void add_envelope_maxima();
  void add_fits(const float* trace);

  PeakOptions options_;
  JointFit joint_;
  AnalyticSignal signal_;
  std::vector<Pulse> pulses_;
  std::vector<Peak> peaks_;
  PeakCounts counts_;
};

// Two-way travel time (s) of a sub-sample index: sample * sample_interval - time_zero.
inline double travel_time(double sample, double sample_interval_s, double time_zero_s) {
  return sample * sample_interval_s - time_zero_s;
}

// Depth (m) of a reflector: the wave goes there and back.
inline double depth_of(double travel_time_s, double wave_speed) {
  return 0.5 * wave_speed * travel_time_s;
}

// Row floor(d rows / depth_range) of a depth, the paper's first index; -1 outside [0, depth_range).
int depth_row(double depth, double depth_range, int rows);

}  // namespace gprodom::gpr
