// A reflection in a trace, how it is looked for, and what became of all.
#pragma once

#include <Eigen/Core>
#include <cstddef>

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

}  // namespace gprodom::gpr
