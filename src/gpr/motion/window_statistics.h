// Similarity of the traces of a short window, normalised so that it depends neither on gain nor on
// antenna nor on ground. It is the test statistic of the standstill detection.
#pragma once

#include <Eigen/Core>

namespace gprodom::gpr {

// Statistics of a window of n traces. "Residual": trace minus the window's mean trace, without the
// components that also change while the antenna stands (see WindowAnalyser).
struct WindowStatistics {
  double variance = 0.0;       // of the residual, counts^2, per degree of freedom
  double trend = 0.0;          // the largest of the contrasts along the window, over `variance`
  double step = 0.0;           // half the mean square of the step between traces, over `variance`
  double signal = 0.0;         // variance of the mean trace, counts^2
  double samples = 0.0;        // degrees of freedom per trace for white noise
  double white_samples = 0.0;  // the same, given the residual's autocorrelation
  int traces = 0;              // used
  int outlier = -1;            // trace that alone holds most of the residual, or -1
};

// Compares the traces of a window.
//
// While the antenna stands a trace is g*s(t - d) + low(t) + noise: a gain g, a time-zero offset d
// of a fraction of a sample, a slow offset `low` and white noise, all drawn anew for each trace.
// What changes with gain and time zero lies, to third order, in the span of s, s', s'' and s''';
// the slow offset in that of the Legendre polynomials up to the third degree. Both are projected
// out. Of what is left the mean square is the noise variance if the antenna stands, and more if it
// moves.
//
// Motion within the window also gives the residual a trend in time, whatever the noise level. It is
// measured by contrasts c (unit vectors over the n traces, orthogonal to the constant): a straight
// line, and the first or last one, two or three traces against the others. At rest, |sum_i c_i
// R_i|^2 per degree of freedom equals the noise variance for each of them.
//
// Keeps its buffers: no allocation once the trace length and number have been seen.
class WindowAnalyser {
 public:
  // traces: samples x n, counts, one trace a column. weight: n, relative inverse noise variance of
  // the traces; 0 leaves a trace out. used: samples, 1 where the sample counts and 0 where it does
  // not (clipped). n >= 4 of positive weight, else the result has traces = 0.
  WindowStatistics analyse(const Eigen::Ref<const Eigen::MatrixXf>& traces,
                           const Eigen::Ref<const Eigen::VectorXf>& weight,
                           const Eigen::Ref<const Eigen::VectorXf>& used);

  // Of the window analysed last: its mean trace (samples), counts.
  const Eigen::VectorXf& mean() const { return mean_; }

  // Mean square of the difference of that mean and another trace (samples), counts^2 per degree of
  // freedom, without what may change while the antenna stands.
  double difference(const Eigen::VectorXf& other, const Eigen::Ref<const Eigen::VectorXf>& used);

 private:
  static constexpr int kPolynomials = 4;
  static constexpr int kNuisances = kPolynomials + 4;

  void resize(Eigen::Index samples, Eigen::Index traces);
  double mean_square_step(int n) const;
  int build_nuisances(const Eigen::Ref<const Eigen::VectorXf>& used);
  void take_out_nuisances(int count, Eigen::Ref<Eigen::VectorXf> trace) const;
  double largest_contrast(int n);
  double whiteness(int n) const;

  Eigen::MatrixXf polynomials_;  // samples x kPolynomials
  Eigen::MatrixXf nuisances_;    // samples x kNuisances, orthonormal
  Eigen::VectorXf used_;         // for which they were built last, and
  int polynomials_used_ = 0;     // how many of them come from polynomials
  Eigen::MatrixXf residual_;     // samples x n, whitened by sqrt(weight)
  Eigen::MatrixXf cumulative_;   // samples x (n + 1), running sums of the residual
  Eigen::VectorXf mean_, contrast_;
};

}  // namespace gprodom::gpr
