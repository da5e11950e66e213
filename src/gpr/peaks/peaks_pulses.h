// Pulse candidates: maxima of the envelope, their gates, and the start values of their fits.
#pragma once

#include <vector>

#include "gpr/peaks/peaks_envelope.h"

namespace gprodom::gpr {

struct Pulse {
  int maximum = 0;      // sample of the envelope's maximum
  double height = 0.0;  // envelope there
  int valley = 0;       // sample of the envelope's minimum before the next pulse (or trace end)
  int gate_end = 0;     // one past the last sample of the gate, at most the trace's length
  double alpha = 0.0;   // per sample: start value
  double omega = 0.0;   // rad per sample: start value
  double centre_omega = 0.0;  // rad per sample: the trace's dominant frequency
};

// Maxima of at least `threshold`, in order of time, of the envelope smoothed over a quarter of a
// period. Of two that are closer than 0.75 of a period, or have no valley between them (below 0.75
// of the lower), the higher is the pulse.
//
// Start values: over the first period from the maximum, z[i + 2] ~ exp(2 (-alpha + j omega)) z[i]
// in least squares, which is the mean instantaneous frequency and slope of the logarithm of the
// envelope, weighted by energy. The gate reaches `gate_periods` of that frequency past the maximum.
void find_pulses(AnalyticSignal& signal, double threshold, double gate_periods,
                 std::vector<Pulse>& pulses);

// Sub-sample place and height of the envelope's maximum: a parabola through it and its neighbours.
struct EnvelopeMaximum {
  double sample = 0.0;
  double height = 0.0;
};
EnvelopeMaximum refine_maximum(const std::vector<float>& envelope, int maximum);

}  // namespace gprodom::gpr
