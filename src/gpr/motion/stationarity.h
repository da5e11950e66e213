// Standstill seen by the radar: consecutive traces are equal up to their noise.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "gpr/filter/clipping.h"
#include "gpr/motion/window_statistics.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// Says when the antenna stands, whatever the wheel does. Each claim is a Standstill; where the
// antenna moves, or nothing can be said, there is none.
//
// A window of traces `stationary_window` long is tested at each trace:
//  1. its residual variance is that of the noise (chi-square about 1), and
//  2. the residual has no trend along the window (its contrasts; this holds whatever the noise is).
// Both within `kSigmas` standard deviations, the degrees of freedom taken from the residual's own
// autocorrelation. Only the middle third of a window that passes is claimed: at its ends the first
// millimetres of a motion do not show yet. So a claim ends a third of the window before its tick.
//
// The noise level is learned, never given: it is the residual variance of a stretch in which
// windows free of trend agree with each other for a whole window's length more, as they do at a
// standstill and not while ground passes by. It follows slow changes, takes a lower level at once
// and a higher one after several windows. Until it is known nothing is claimed, and then the
// stretch itself is.
//
// How well motion is seen (Sight) depends on ground and noise. Let a trace differ from the one
// before by x, in units of the noise's deviation, for the ground passed. The straight line's
// contrast over n traces passes its limit L once x^2 n (n^2 - 1) / 12 > L. While the antenna moves,
// x is known from the mean square of the steps from trace to trace, x^2 + 2, and from the
// residual's variance, 1 + x^2 n (n + 1) / 12. This is the finer one of slow motion; of fast motion
// it falls short, as traces are only so unlike however far apart. So the larger x is taken.
//
// A dead antenna shows no ground: windows whose mean trace does not stand out of the noise say
// nothing. A single spiked trace is found by its share of the residual and left out.
class StationarityFrontEnd : public FrontEnd {
 public:
  // window: s of traces compared.
  explicit StationarityFrontEnd(double window);

  void add_trace(const GprTrace& trace) override;
  // Standstills, whose `score` is the residual variance over that of the noise, and, once the noise
  // is known, a Sight of each window after the other.
  std::vector<Finding> tick(TimeNs tick) override;
  void reset() override;

  // Learned noise variance of smoothed traces, counts^2; 0 while unknown.
  double noise_variance() const { return noise_; }

 private:
  struct Span {
    TimeNs from = 0, to = 0;
    double score = 0.0;
  };

  void close_bin();
  void test_window();
  WindowStatistics analyse_window();
  double samples(const WindowStatistics& s) const;  // per trace that are worth one each
  double trend_limit(const WindowStatistics& s) const;
  double variance_limit(const WindowStatistics& s) const;
  void learn_noise(const WindowStatistics& s, const Span& claim);
  void claim(const Span& span);
  void see(const WindowStatistics& s);

  TimeNs window_;

  // The bin being filled: traces of one twelfth of the window, averaged.
  Eigen::VectorXf sum_, used_;  // sum of its traces; 1 where no sample is clipped
  ClippingDetector clipping_;
  int bin_traces_ = 0;
  TimeNs bin_start_ = 0, last_time_ = 0, bin_time_sum_ = 0;
  double sample_interval_ = 0.0;

  // The window's bins, oldest first.
  Eigen::MatrixXf traces_;       // samples x bins
  Eigen::MatrixXf sample_used_;  // samples x bins
  Eigen::VectorXf weight_;       // traces per bin, 0: spiked
  Eigen::VectorXf window_used_;  // samples that count in all bins
  std::vector<TimeNs> times_;
  int bins_ = 0;
  WindowAnalyser analyser_;

  // Noise: variance and effective samples per trace, and the stretch that may teach it.
  double noise_ = 0.0, noise_samples_ = 0.0;
  double run_variance_ = 0.0, run_samples_ = 0.0;
  int run_ = 0;
  TimeNs run_from_ = 0;

  std::vector<Span> spans_;  // not yet told, oldest first; the last may still grow
  TimeNs told_ = 0;          // up to where the last span has been told

  std::vector<Sight> sights_;  // not yet told
  TimeNs seen_ = 0;            // end of the newest
};

}  // namespace gprodom::gpr
