// Damped sinusoids fitted together by variable projection (Golub and Pereyra 1973, in Kaufman's
// form of 1975) with Levenberg-Marquardt:
//     f(i) = gamma + sum_k [i >= s_k] exp(-alpha_k (i - s_k))
//                                     (a_k cos(omega_k (i - s_k)) + b_k sin(omega_k (i - s_k))).
// alpha_k, omega_k are searched; for each trial the linear a_k = beta_k cos(phi_k),
// b_k = -beta_k sin(phi_k) and gamma are solved for. Everything lies on the stack.
#pragma once

#include <Eigen/Core>
#include <array>

namespace gprodom::gpr {

constexpr int kMaxJointPulses = 3;
constexpr int kMaxGroupSamples = 128;  // even; one is for padding
constexpr int kMaxGroupParameters = 4 * kMaxJointPulses + 1;

// Samples that are fitted; index rises, may have gaps.
struct GroupSamples {
  int size = 0;
  std::array<int, kMaxGroupSamples> index;
  std::array<double, kMaxGroupSamples> value;
};

struct DampedSinusoid {
  int start = 0;  // s_k: no part in f before this sample
  double alpha = 0.0;
  double omega = 0.0;
  double cosine = 0.0;                      // a_k
  double sine = 0.0;                        // b_k
  double omega_min = 0.0, omega_max = 0.0;  // bounds of the search
  double alpha_min = 0.0, alpha_max = 0.0;
};

enum class FitStatus { kConverged, kNotConverged, kOutOfBounds, kTooFewSamples };

// Order of `inverse`: a_1, b_1, ..., a_K, b_K, gamma, alpha_1, omega_1, ..., alpha_K, omega_K.
using GroupMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                  kMaxGroupParameters, kMaxGroupParameters>;
struct GroupFit {
  FitStatus status = FitStatus::kNotConverged;
  int offender = 0;  // the pulse to blame where a fit failed
  int iterations = 0;
  double gamma = 0.0;
  double residual_sum = 0.0;  // of squares
  int freedom = 0;            // samples less parameters
  // What leaving pulse k out would add to residual_sum, every alpha and omega kept.
  std::array<double, kMaxJointPulses> contribution{};
  std::array<double, kMaxGroupSamples> residual;  // data less curve, of each sample
  GroupMatrix inverse;  // (J' J)^-1; times the noise variance it is the covariance
};

// Fits `count` (1..3) pulses from the start values in them and leaves the estimates there. The
// search ends when the next step would be under a thirtieth of its standard error.
void fit_pulses(const GroupSamples& samples, DampedSinusoid* pulses, int count, int max_iterations,
                GroupFit& fit);

}  // namespace gprodom::gpr
