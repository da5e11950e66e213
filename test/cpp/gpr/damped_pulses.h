// Traces of damped sinusoids with a sharp onset, and the Cramer-Rao bound of the time and amplitude
// of their first maxima, computed from numerical derivatives alone: none of the code under test.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

#include "support/derivative.h"

namespace gprodom::gpr {

constexpr double kPi = 3.14159265358979323846;
constexpr int kTraceSamples = 201;
constexpr double kPulseOmega = 0.2 * kPi;  // 500 MHz at 0.2 ns

// beta exp(-alpha i) cos(omega i + phi) from sample `onset` on, nothing before.
struct TruePulse {
  int onset = 0;
  double alpha = 0.0, beta = 1.0, omega = kPulseOmega, phi = 0.0;

  double curve(double i) const { return beta * std::exp(-alpha * i) * std::cos(omega * i + phi); }
  double slope(double i) const {
    return -beta * std::exp(-alpha * i) *
           (alpha * std::cos(omega * i + phi) + omega * std::sin(omega * i + phi));
  }
};

// Envelope down to a tenth in 2 to 3 periods, any phase.
inline TruePulse random_pulse(std::mt19937& random, int onset, double beta = 1.0) {
  std::uniform_real_distribution<double> periods(2.0, 3.0), phase(-kPi, kPi);
  TruePulse pulse;
  pulse.onset = onset;
  pulse.beta = beta;
  pulse.alpha = std::log(10.0) / (periods(random) * 2.0 * kPi / pulse.omega);
  pulse.phi = phase(random);
  return pulse;
}

inline double model(const std::vector<TruePulse>& pulses, double gamma, int sample) {
  double value = gamma;
  for (const TruePulse& pulse : pulses) {
    if (sample >= pulse.onset) value += pulse.curve(sample - pulse.onset);
  }
  return value;
}

inline std::vector<float> noisy_trace(const std::vector<TruePulse>& pulses, double gamma,
                                      double sigma, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<float> trace(kTraceSamples);
  for (int i = 0; i < kTraceSamples; ++i) {
    trace[static_cast<std::size_t>(i)] =
        static_cast<float>(model(pulses, gamma, i) + sigma * noise(random));
  }
  return trace;
}

// The maximum of the curve nearest to `guess`, by bisection of its slope.
inline double maximum_near(const TruePulse& pulse, double guess) {
  const double period = 2.0 * kPi / pulse.omega;
  double best = 0.0, distance = 1e9;
  for (double low = guess - period; low < guess + period; low += period / 64.0) {
    double a = low, b = low + period / 64.0;
    if (!(pulse.slope(a) > 0.0 && pulse.slope(b) <= 0.0)) continue;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (a + b);
      (pulse.slope(middle) > 0.0 ? a : b) = middle;
    }
    if (std::abs(a - guess) < distance) {
      distance = std::abs(a - guess);
      best = a;
    }
  }
  return best;
}

struct PeakBound {
  double time = 0.0, amplitude = 0.0;              // of the maximum nearest to a place
  double time_sigma = 0.0, amplitude_sigma = 0.0;  // bound of their errors
};

// Bound for the maximum of pulses[k] nearest to `place` (samples from its onset), every parameter
// of every pulse and gamma unknown, the onsets known, from samples [begin, end).
inline PeakBound peak_bound(const std::vector<TruePulse>& pulses, double gamma, std::size_t k,
                            double place, int begin, int end, double sigma) {
  PeakBound bound;
  bound.time = maximum_near(pulses[k], place);
  bound.amplitude = gamma + pulses[k].curve(bound.time);
  // All samples, and the maximum's time and amplitude.
  const auto seen = [&](const Eigen::VectorXd& d) {
    std::vector<TruePulse> moved = pulses;
    const double* by = d.data();
    for (TruePulse& pulse : moved)
      for (double* const parameter : {&pulse.alpha, &pulse.beta, &pulse.omega, &pulse.phi})
        *parameter += *by++;
    Eigen::VectorXd all(end - begin + 2);
    for (int i = begin; i < end; ++i) all[i - begin] = model(moved, gamma + *by, i);
    const double time = maximum_near(moved[k], bound.time);
    all.tail<2>() << time, gamma + *by + moved[k].curve(time);
    return all;
  };
  const auto count = static_cast<Eigen::Index>(4 * pulses.size() + 1);
  const Eigen::MatrixXd J = numeric_jacobian(count, 1e-5, seen);
  const auto of_samples = J.topRows(end - begin), of_peak = J.bottomRows(2);
  const Eigen::MatrixXd information = of_samples.transpose() * of_samples / (sigma * sigma);
  const Eigen::MatrixXd covariance = of_peak * information.inverse() * of_peak.transpose();
  bound.time_sigma = std::sqrt(covariance(0, 0));
  bound.amplitude_sigma = std::sqrt(covariance(1, 1));
  return bound;
}

}  // namespace gprodom::gpr
