// Prior of a wheel's slip: usually none, sometimes much, and then for seconds. The slip of a step
// is l = ln(true distance / distance by the odometry); the wheel's scale is separate.
// docs/estimation.md, "Slip of a step".
#pragma once

#include <algorithm>
#include <cmath>

#include "gprodom/config.h"

namespace gprodom {

struct SlipModel {
  double share = 0.3;     // share of the path on which a wheel slips
  double size = 0.5;      // standard deviation of l while it slips
  double lasts_s = 20.0;  // how long a slip lasts
  double surface = 0.02;  // standard deviation of l without slip, due to the ground under the wheel
  double change = 0.02;   // 1/sqrt(s): random walk of l while a slip lasts

  // Standard deviation of l if it is not known whether the wheel slips.
  double sigma() const { return std::sqrt(share * size * size + surface * surface); }

  // Probability that the wheel slips on a step whose l has this standard deviation.
  double probability(double sigma) const {
    return std::clamp((sigma * sigma - surface * surface) / (size * size), 0.0, 1.0);
  }

  // Probability of a slip somewhere in a time. Those that begin leave the share as it is.
  double probability_within(double seconds) const {
    const double grips = std::max(0.0, 1 - share);
    return grips > 0 ? 1 - grips * std::exp(-share / grips * seconds / lasts_s) : 1.0;
  }

  // Correlation of l over a time: the probability that no slip has begun or ended.
  double correlation(double seconds) const { return std::exp(-seconds / lasts_s); }
};

inline SlipModel slip_model(const WheelConfig& config) {
  SlipModel model;
  model.share = config.slip_share;
  return model;
}

}  // namespace gprodom
