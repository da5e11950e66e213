// Standstill seen by the radar: consecutive traces are equal up to their noise.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "gpr/filter/clipping.h"
#include "gpr/motion/window_statistics.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// Detects when the antenna stands, independently of the wheel. Each detection is a Standstill.
// There is none while the antenna moves, or while it cannot be decided.
//
// A window of traces `window` long is tested at each trace:
//  1. its residual variance is that of the noise (chi-square about 1), and
//  2. the residual has no trend along the window (its contrasts; this holds whatever the noise is).
// Both must hold within `kSigmas` standard deviations. The degrees of freedom come from the
// residual's own autocorrelation. Only the middle third of a window that passes is reported,
// because the first millimetres of a motion at its ends are not visible yet. So a standstill ends a
// third of the window before its tick.
//
// The noise level is learned, never configured: it is the residual variance of a stretch in which
// windows without trend agree with each other for one more window length. They do so at a
// standstill and not while the antenna moves. The level follows slow changes; a lower one is taken
// at once, a higher one after several windows. Nothing is reported before the level is known; then
// the stretch itself is.
//
// How slow a motion can be seen (Sight) depends on ground and noise. Let two successive traces
// differ by x because of the motion, in units of the noise's standard deviation. The contrast of a
// straight line over n traces exceeds its limit L if x^2 n (n^2 - 1) / 12 > L. While the antenna
// moves, x follows from the mean square of the steps from trace to trace, x^2 + 2, and also from
// the residual's variance, 1 + x^2 n (n + 1) / 12. The latter is more precise for slow motion, but
// too small for fast motion, since the difference of traces is bounded. So the larger x is taken.
//
// A motion too slow for the window shows over a longer time: the mean trace of each window that
// passes is compared with that of an earlier one, the anchor. As long as they are equal within
// their noise, the antenna has not moved since then (Standstill::since), whatever lies between;
// otherwise the window becomes the anchor.
//
// A dead antenna shows no ground: windows whose mean trace is not above the noise are ignored. A
// single spiked trace is found by its share of the residual and left out.
class StationarityFrontEnd : public FrontEnd {
 public:
  // s of traces compared: twelve bins of one trace each at 20 traces/s, the fewest from which a
  // trend can be told. A longer window tells a standstill later.
  static constexpr double kWindow = 0.6;

  explicit StationarityFrontEnd(double window = kWindow);

  void add_trace(const GprTrace& trace) override;
  // Returns standstills, whose `score` is the residual variance over that of the noise. Once the
  // noise is known, also a Sight for each window.
  std::vector<Finding> tick(TimeNs tick) override;
  void reset() override;

  // Learned noise variance of smoothed traces, counts^2; 0 while unknown.
  double noise_variance() const { return noise_; }

 private:
  struct Span {
    TimeNs from = 0, to = 0;
    double score = 0.0;
    TimeNs since = 0;
  };
  struct Anchor {
    Eigen::VectorXf mean, used;  // of the window's traces; samples not clipped
    double weight = 0.0;         // traces; 0: none
    TimeNs time = 0;             // begin of its window
  };

  void close_bin();
  void forget_bins(int count);  // the oldest
  void test_window();
  WindowStatistics analyse_window();
  double samples(const WindowStatistics& s) const;  // degrees of freedom per trace
  double trend_limit(const WindowStatistics& s) const;
  double variance_limit(const WindowStatistics& s) const;
  void learn_noise(const WindowStatistics& s, const Span& claim);
  void claim(const Span& span);
  TimeNs standing_since();
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

  // Noise: variance and effective samples per trace, and the stretch it may be learned from.
  double noise_ = 0.0, noise_samples_ = 0.0;
  double run_variance_ = 0.0, run_samples_ = 0.0;
  int run_ = 0;
  TimeNs run_from_ = 0;

  Anchor anchor_;
  std::vector<Span> spans_;  // not yet reported, oldest first; the last may still grow
  TimeNs told_ = 0;          // end of what has been reported of the last span

  std::vector<Sight> sights_;  // not yet reported
  TimeNs seen_ = 0;            // end of the newest
};

}  // namespace gprodom::gpr
