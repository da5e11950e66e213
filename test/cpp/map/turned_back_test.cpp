// A robot that comes back beside the way just driven.
#include <gtest/gtest.h>

#include <cmath>

#include "gpr/synthetic_ground.h"
#include "map/mapper.h"

namespace gprodom {
namespace {

constexpr double kStep = 0.1, kOut = 12.0;  // m from state to state; of the way out
constexpr int kTraces = 3;                  // from state to state

double place_at(double way) { return way < kOut ? way : 2 * kOut - way; }

// A mapper that has driven out and back. `alike`: correlation of the ground on the way back with
// that on the way out, as from a little aside.
struct Outcome {
  double found_after_m = -1.0;  // way back until the first revisit
  double stored_m = 0.0;
};
Outcome out_and_back(float alike) {
  Mapper mapper(default_config(), std::nullopt, std::nullopt);
  const gpr::SyntheticGround there(1, kOut + 1.0), aside(2, kOut + 1.0);
  gpr::SyntheticRadar radar(1, 10.0), other(2, 0.0);
  Outcome outcome;
  for (int i = 0; kStep * i < 2 * kOut; ++i) {
    MapInput input;
    PathState state;
    state.time = from_seconds(1000.0 + 0.2 * i);
    state.pose.p.x() = place_at(kStep * i);
    state.covariance = state.pose_covariance = 1e-8 * i * Eigen::Matrix3d::Identity();
    input.states.push_back(state);
    for (int k = 1 - kTraces; k <= 0 && i > 0; ++k) {
      const double at = i + static_cast<double>(k) / kTraces, place = place_at(kStep * at);
      GprTrace trace = radar.measure(there, place, 1000.0 + 0.2 * at);
      if (kStep * at > kOut) {
        const GprTrace beside = other.measure(aside, place, 1000.0 + 0.2 * at);
        for (std::size_t n = 0; n < trace.samples.size(); ++n) {
          trace.samples[n] =
              alike * trace.samples[n] + std::sqrt(1 - alike * alike) * beside.samples[n];
        }
      }
      input.traces.push_back(std::move(trace));
    }
    const MapAnswer answer = mapper.run(input);
    if (outcome.found_after_m < 0 && !answer.revisits.empty())
      outcome.found_after_m = kStep * i - kOut;
  }
  const gpr::TraceMemory memory = mapper.take_ground().memory;
  outcome.stored_m = static_cast<double>(memory.kept().size()) * memory.spacing();
  return outcome;
}

// The next lane of a survey lies beside this one, and may find it alone.
TEST(TurnedBack, GroundIsStoredAgainWhereHalfOfItIsNew) {
  const Outcome same = out_and_back(1.0F), half = out_and_back(0.6F);
  EXPECT_LT(same.stored_m, 1.4 * kOut);
  ASSERT_GT(half.found_after_m, 0.0);
  EXPECT_GT(half.stored_m, 1.8 * kOut);
}

}  // namespace
}  // namespace gprodom
