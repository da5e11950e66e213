#include "motion/slip/ground_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gprodom::slip {
namespace {

// Spans of 0.4 m on ground whose length changes from place to place, seen with an error a span. On
// every other stretch of 8 m the wheel slips.
GroundNoise after_drive(double place_sigma, double span_sigma, double slip, int seed) {
  constexpr double kSpan_m = 0.4, kStretch_m = 8.0;
  std::mt19937 engine(static_cast<unsigned>(seed));
  std::normal_distribution<double> normal;
  const double kept = std::exp(-kSpan_m / GroundNoise::kPlace);
  double place = place_sigma * normal(engine);
  GroundNoise noise;
  for (double at = 0.0; at < 80.0; at += kSpan_m) {
    const bool slips = std::fmod(at, 2 * kStretch_m) > kStretch_m;
    noise.add(at, 2.0 + place + span_sigma * normal(engine) + (slips ? slip : 0.0));
    place = kept * place + place_sigma * std::sqrt(1 - kept * kept) * normal(engine);
  }
  return noise;
}

// The scatter of all spans is 0.27 where the wheel slips. Little of that may pass for the ground: a
// ground that scatters as much hides the slip. Slips that begin within a span are the hard case.
TEST(GroundNoise, IsLearntWhereTheWheelSlipsHalfOfTheWay) {
  for (const double slip : {0.0, -0.4}) {
    double place = 0.0, span = 0.0;
    constexpr int kDrives = 20;
    for (int seed = 0; seed < kDrives; ++seed) {
      const GroundNoise noise = after_drive(0.15, 0.1, slip, seed);
      place += noise.place_sigma() / kDrives;
      span += noise.span_sigma() / kDrives;
    }
    EXPECT_NEAR(place, 0.15, 0.07) << "slip " << slip;
    EXPECT_NEAR(span, 0.1, 0.04) << "slip " << slip;
  }
}

}  // namespace
}  // namespace gprodom::slip
