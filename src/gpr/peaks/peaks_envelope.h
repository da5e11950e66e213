// The analytic signal of a trace: it and its Hilbert transform, whose modulus is the envelope.
#pragma once

#include <cstddef>
#include <vector>

namespace gprodom::gpr {

// All of the trace's length. Real part: the trace less its mean.
struct AnalyticSignal {
  std::vector<float> real;
  std::vector<float> imaginary;
  std::vector<float> envelope;
  std::vector<float> smoothed;  // the envelope without ripple; set by find_pulses
  std::vector<float> padded;    // work space: the real part between two margins of zeros
};

// Fills `signal` from `size` samples; buffers grow on the first call only.
//
// The Hilbert transform is an antisymmetric FIR filter, h[k] = 2 / (pi k) for odd k, 0 for even k,
// under a Hamming window of |k| <= 31. Its gain is within 0.4 % of 1 from 0.03 to 0.47 cycles
// per sample. An FFT would wrap the end of a trace round to its start; this sees zeros there.
void analytic_signal(const float* trace, std::size_t size, AnalyticSignal& signal);

}  // namespace gprodom::gpr
