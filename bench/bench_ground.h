// Traces and ground for the benches: enough of them for a cost.
#pragma once

#include <random>
#include <vector>

#include "gpr/revisit/patch_filter.h"
#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {

// A drive over a reflector here and there, 20 traces a second at 0.4 m/s.
inline std::vector<GprTrace> synthetic_drive(int count, const SyntheticGround& ground) {
  SyntheticRadar radar(2, 60.0);
  std::vector<GprTrace> traces;
  for (int i = 0; i < count; ++i) traces.push_back(radar.measure(ground, 1.0 + 0.02 * i, 0.05 * i));
  return traces;
}

// Noise smoothed along the track, with all the rows that so many samples can have.
inline Columns noise_ground(Eigen::Index columns, Eigen::Index samples, float level,
                            std::mt19937& random) {
  std::normal_distribution<float> normal;
  Columns ground = Columns::NullaryExpr(columns, samples, [&] { return level * normal(random); });
  smooth_along(4.0, ground);
  return ground;
}

inline Columns noise_ground(Eigen::Index columns) {
  std::mt19937 random(1);
  return noise_ground(columns, SyntheticGround::kSamples, 1000.0F, random);
}

}  // namespace gprodom::gpr
