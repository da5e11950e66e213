// Reflections in one filtered trace: the damped-sinusoid fit of Li et al. (arXiv 2503.18301),
//     A'(i) = beta exp(-alpha i) cos(omega i + phi) + gamma,
// one sinusoid per pulse, fitted by least squares (the maximum likelihood under white noise). The
// peak is the first maximum of the fitted curve.
//
// Stages, each usable alone: analytic_signal (peaks_envelope.h), find_pulses (peaks_pulses.h),
// fit_pulses (peaks_varpro.h), peak_of_fit (peaks_covariance.h).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace gprodom::gpr {

// Order of Peak::covariance.
enum PeakParameter {
  kPeakTime,
  kPeakAmplitude,
  kPeakAlpha,
  kPeakBeta,
  kPeakGamma,
  kPeakOmega,
  kPeakPhi
};
using PeakCovariance = Eigen::Matrix<double, 7, 7>;

// Times in samples of the trace, amplitudes in its unit. Without the fit (PeakOptions::fit) only
// `sample`, `amplitude` and the gate are set, the last three from the envelope.
struct Peak {
  double sample = 0.0;     // sub-sample index of the first maximum of the curve
  double amplitude = 0.0;  // A' there, gamma included
  double alpha = 0.0;      // per sample, > 0
  double beta = 0.0;       // > 0
  double gamma = 0.0;      // shared by pulses that were fitted together
  double omega = 0.0;      // rad per sample
  double phi = 0.0;        // rad, at gate_begin: i = 0 is sample gate_begin
  double residual = 0.0;   // RMS of data - curve over RMS of data - gamma, within the gate
  int gate_begin = 0;      // first and one past the last sample of the pulse that were fitted
  int gate_end = 0;
  int joint = 0;  // pulses fitted together with this one, itself included; 0: no fit
  PeakCovariance covariance = PeakCovariance::Zero();
};

struct PeakOptions {
  bool fit = true;  // false: envelope maximum and a parabola through it
  double noise_sigma =
      0.0;               // of one sample, in the trace's unit; 0: taken from each fit's residual
  double min_snr = 3.5;  // least envelope of a pulse over noise_sigma
  double min_relative = 0.05;  // least envelope of a pulse over the trace's largest
  double gate_periods = 1.5;   // from the envelope maximum on
  int max_joint = 3;           // overlapping pulses fitted together, 1..3
  double significance = 0.01;  // of the F-test that a pulse must pass to be kept
  double max_residual = 0.3;   // misfit energy less noise, over signal energy
  int max_iterations = 15;
};

// Counts of what happened to the pulses since construction.
struct PeakCounts {
  std::size_t traces = 0;
  std::size_t pulses = 0;  // candidates: envelope maxima above the thresholds
  std::size_t accepted = 0;
  std::size_t insignificant = 0;  // failed the F-test: the other pulses explain the data
  std::size_t not_converged = 0;
  std::size_t out_of_bounds = 0;  // not a decaying oscillation near the pulse's own frequency
  std::size_t misfit = 0;         // residual too large
};

// Keeps its buffers: no allocation from the second trace of one length on.
class PeakExtractor {
 public:
  // Throws std::invalid_argument on an option out of range.
  explicit PeakExtractor(const PeakOptions& options = {});
  ~PeakExtractor();
  PeakExtractor(PeakExtractor&&) noexcept;
  PeakExtractor& operator=(PeakExtractor&&) noexcept;

  // Peaks of a trace of `size` samples, background removed and band-passed, in order of time. The
  // result is valid until the next call. A trace with a value that is not finite has no peaks.
  const std::vector<Peak>& extract(const float* trace, std::size_t size);

  const PeakCounts& counts() const;
  const PeakOptions& options() const;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
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
