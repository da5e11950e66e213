// Time-zero tracking: traces start early or late by a fraction of a sample up to a few samples. The
// direct wave shows by how much, since the ground hardly changes it.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace gprodom::gpr {

// Delays x by `delay` samples (out[i] = x(i - delay)) with an eight-point windowed sinc. Beyond the
// ends the end values continue. Exact to 1e-3 of the amplitude up to 0.2 of the sampling rate.
// x: n samples -> out, not the same array.
void delay_trace(const float* x, int n, double delay, float* out);

// The delay of each trace against the mean of the earlier ones, by least squares on the direct
// wave: whole samples by correlation, the fraction by Gauss-Newton on gain and delay (linearised as
// in B. D. Lucas, T. Kanade 1981).
class TimeZeroTracker {
 public:
  // period: of the antenna's centre frequency, in samples (> 2). max_delay: samples; a larger delay
  // is not that of the direct wave, and is not applied.
  TimeZeroTracker(double period, double max_delay);

  // x: n >= 32 samples -> out, aligned, not the same array. Returns the delay removed, in samples;
  // if none can be found, it is the last one found. The first trace defines time zero. No
  // allocation after the first trace of a length.
  double align(const float* x, int n, float* out);
  void reset();

 private:
  void place_window();
  int best_whole_delay(const float* x, int n) const;
  std::optional<double> refine(const float* x, int n, double delay);

  double period_;
  int max_delay_;
  Eigen::VectorXf reference_;
  double traces_ = 0.0;         // in the reference
  double delay_ = 0.0;          // the last one found
  int lost_ = 0;                // traces since then
  int first_ = 0, length_ = 0;  // of the direct wave, in the reference
  Eigen::VectorXf moved_;
};

}  // namespace gprodom::gpr
