#include "gpr/peaks/peaks_covariance.h"

#include <array>
#include <cmath>

namespace gprodom::gpr {
namespace {

constexpr double kTurn = 6.28318530717958647692;

}  // namespace

Peak peak_of_fit(const DampedSinusoid* pulses, int count, int k, const GroupFit& fit,
                 double noise_variance) {
  const DampedSinusoid& pulse = pulses[k];
  const double a = pulse.cosine, b = pulse.sine;
  Peak peak;
  peak.gate_begin = pulse.start;
  peak.alpha = pulse.alpha;
  peak.omega = pulse.omega;
  peak.gamma = fit.gamma;
  peak.beta = std::hypot(a, b);
  peak.phi = std::atan2(-b, a);

  const double theta = -std::atan2(peak.alpha, peak.omega);
  const double turns = std::ceil((peak.phi - theta) / kTurn);
  const double t = (theta - peak.phi + kTurn * turns) / peak.omega;
  const double decayed = peak.beta * std::exp(-peak.alpha * t);
  peak.sample = pulse.start + t;
  peak.amplitude = peak.gamma + decayed * std::cos(theta);

  // d(alpha, beta, gamma, omega, phi) / d(a, b, gamma, alpha, omega), beta = hypot(a, b).
  const double beta = peak.beta, beta2 = beta * beta;
  Eigen::Matrix<double, 7, 5> jacobian = Eigen::Matrix<double, 7, 5>::Zero();
  jacobian(kPeakAlpha, 3) = 1.0;
  jacobian.row(kPeakBeta) << a / beta, b / beta, 0.0, 0.0, 0.0;
  jacobian(kPeakGamma, 2) = 1.0;
  jacobian(kPeakOmega, 4) = 1.0;
  jacobian.row(kPeakPhi) << b / beta2, -a / beta2, 0.0, 0.0, 0.0;
  // The place of the maximum. The amplitude's derivative along t vanishes there.
  const double omega = peak.omega, norm2 = peak.alpha * peak.alpha + omega * omega;
  jacobian.row(kPeakTime) = -jacobian.row(kPeakPhi) / omega;
  jacobian(kPeakTime, 3) += -1.0 / norm2;
  jacobian(kPeakTime, 4) += peak.alpha / (norm2 * omega) - t / omega;
  const double by_phase = -decayed * std::sin(theta);
  jacobian.row(kPeakAmplitude) = by_phase * jacobian.row(kPeakPhi) +
                                 decayed * std::cos(theta) / beta * jacobian.row(kPeakBeta);
  jacobian(kPeakAmplitude, 2) += 1.0;
  jacobian(kPeakAmplitude, 3) += -t * decayed * std::cos(theta);
  jacobian(kPeakAmplitude, 4) += t * by_phase;

  const int linear = 2 * count + 1;
  const std::array place{2 * k, 2 * k + 1, 2 * count, linear + 2 * k, linear + 2 * k + 1};
  const Eigen::Matrix<double, 5, 5> inverse = fit.inverse(place, place);
  const Eigen::Matrix<double, 7, 5> half = jacobian.lazyProduct(inverse);
  peak.covariance = noise_variance * half.lazyProduct(jacobian.transpose());
  return peak;
}

}  // namespace gprodom::gpr
