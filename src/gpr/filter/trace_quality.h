// Detects dead and spiked traces, so that they can be left out.
#pragma once

#include <Eigen/Core>

namespace gprodom::gpr {

enum class TraceQuality : signed char {
  kGood = 0,
  kDead = 1,    // no radar signal: constant, noise alone, or far below the usual amplitude
  kSpiked = 2,  // a glitch of the whole trace, or of one of its samples
};

// Judges each trace of a stream by itself and against the last good ones. Without later traces, the
// first traces after a real, lasting jump may be called spiked, but never more than two in a row.
//
// dead: the differences of neighbouring samples have 1.5 times the mean square of the samples or
//   more (white noise: 2; a signal sampled as radars do: under 1), or the mean square is under
//   1/400 of the usual one.
// spiked, the trace: the mean squared difference to the last good trace is over a quarter of the
//   sum of both mean squares (for two unrelated traces it is 1), and far above its recent level
//   (mean of its logarithm plus three mean deviations).
// spiked, a sample: it differs from the cubic through its four neighbours by more than half the
//   largest value of the trace.
class TraceCheck {
 public:
  // samples: n >= 8. No allocation after the first trace of a length.
  TraceQuality check(const float* samples, int n);
  void reset();

 private:
  static constexpr int kMaxSpikedInARow = 2;

  bool is_glitch(double power, double difference);

  Eigen::VectorXf last_;  // the last good trace, without its mean
  Eigen::VectorXf trace_;
  double usual_power_ = 0.0;
  double log_difference_ = 0.0, log_deviation_ = 0.0;
  int seen_ = 0, spiked_in_a_row_ = 0;
};

}  // namespace gprodom::gpr
