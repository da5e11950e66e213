// From a fitted damped sinusoid to its peak: first maximum, amplitude and their covariance.
#pragma once

#include "gpr/peaks/peak.h"
#include "gpr/peaks/peaks_varpro.h"

namespace gprodom::gpr {

// Peak of pulse `k` of a converged fit of `count` pulses, whose noise has the given variance. The
// peak is the curve's first maximum from the pulse's start on, at the least t >= 0 of
//     t = (theta_0 - phi + 2 pi m) / omega,   theta_0 = -atan(alpha / omega),
// and the covariance follows by the delta method. Does not set residual, gate_end and joint.
Peak peak_of_fit(const DampedSinusoid* pulses, int count, int k, const GroupFit& fit,
                 double noise_variance);

}  // namespace gprodom::gpr
