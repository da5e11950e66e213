// Zero-phase filters along a trace: band-pass, dewow, gain. T is float or double.
//
// Finite impulse responses, run forwards and backwards, instead of recursive filters, because their
// reach is known and short (a recursive one rings on after the direct wave), because both runs make
// one symmetric kernel whose sum is exact in single precision, and because output samples are
// independent, so that four are computed at a time.
#pragma once

#include <vector>

namespace gprodom::gpr {

// Band-pass of odd length nearest to `length_s` seconds: an ideal band-pass from low_hz to high_hz
// under a triangular window, scaled to gain 1 in mid-band, as scipy.signal.firwin(taps, [low,
// high], window="triang", pass_zero=False) gives. With high_hz at or above half the sampling rate
// it is a high-pass. Throws std::invalid_argument unless 0 < low_hz < high_hz and low_hz lies below
// half the sampling rate.
std::vector<double> design_band_pass(double low_hz, double high_hz, double sample_interval_s,
                                     double length_s);

// A filter forwards and backwards: |H|^2, no phase. Kernel of 2 * taps - 1 samples, symmetric.
template <typename T>
class ZeroPhaseFilter {
 public:
  ZeroPhaseFilter() = default;
  // taps: of the filter that is run forwards and backwards; any number.
  explicit ZeroPhaseFilter(const std::vector<double>& taps);

  // x: n samples -> out, which may be x. The trace is continued beyond its ends by its end values.
  // No allocation after the first call of a length.
  void apply(const T* x, int n, T* out);

 private:
  std::vector<T> kernel_;
  std::vector<T> extended_, result_;
};

// Subtracts from each sample the mean over the 2 * half_width + 1 samples around it (fewer at the
// ends). This removes the slow "wow" of the receiver. x -> out, not the same array. The cost does
// not depend on the width.
template <typename T>
void dewow(const T* x, int n, int half_width, T* out);

// Gain over travel time, for samples i: g = max(i, 1)^power * exp(rate * i), constant from sample
// flat_after on, as in the pictures of CMU-GPR. rate is per sample; rate 0 and power 0: no gain.
std::vector<double> gain_curve(int n, double rate, double power, int flat_after);

}  // namespace gprodom::gpr
