// A robot that drives the same way again and again, over ground that looks different to it each
// time: it wanders, and what lies aside is another ground to the antenna.
#include <gtest/gtest.h>

#include <cmath>

#include "gpr/synthetic_ground.h"
#include "map/mapper.h"

namespace gprodom {
namespace {

constexpr double kStep = 0.1, kWay = 30.0;  // m from state to state; of a pass
constexpr int kStates = 300;                // of a pass
constexpr TimeNs kInterval = 200'000'000;   // ns from state to state
constexpr int kTraces = 3;                  // from state to state

TimeNs time_of(int state) { return from_seconds(1000.0) + state * kInterval; }

// Ahead and backwards in turn.
double place_at(double state) {
  const double way = std::fmod(kStep * state, 2 * kWay);
  return way < kWay ? way : 2 * kWay - way;
}

// That the state is where one of the first pass was, as another process tells it.
Displacement seen_again(int state) {
  Displacement revisit;
  revisit.kind = DisplacementKind::kRevisit;
  revisit.from = time_of(static_cast<int>(std::lround(place_at(state) / kStep)));
  revisit.to = time_of(state);
  revisit.sigma_m = 0.01;
  revisit.mirrored = state / kStates % 2 == 1;  // by the direction of driving
  revisit.valid = true;
  return revisit;
}

// m of ground that are stored after so many passes.
double stored_m(int passes, bool tied) {
  Mapper mapper(default_config(), std::nullopt, std::nullopt);
  gpr::SyntheticRadar radar(1, 60.0);
  for (int pass = 0; pass < passes; ++pass) {
    const gpr::SyntheticGround there(static_cast<unsigned>(pass) + 1, kWay);
    MapInput input;
    for (int i = pass * kStates; i < (pass + 1) * kStates; ++i) {
      PathState state;
      state.time = time_of(i);
      state.pose.p.x() = place_at(i);
      state.covariance = state.pose_covariance = 1e-8 * i * Eigen::Matrix3d::Identity();
      input.states.push_back(state);
      for (int k = 1 - kTraces; k <= 0 && i > 0; ++k) {
        const double at = i + static_cast<double>(k) / kTraces;
        const double seconds = 1000.0 + at * to_seconds(kInterval);
        input.traces.push_back(radar.measure(there, place_at(at), seconds));
      }
      if (tied && pass > 0 && i % 50 == 25) input.revisits.push_back(seen_again(i));
      if (i % 10 < 9) continue;
      mapper.run(input);
      input = {};
    }
  }
  const gpr::TraceMemory memory = mapper.take_ground().memory;
  return static_cast<double>(memory.kept().size()) * memory.spacing();
}

TEST(CrowdedGround, OfManyPassesSideBySideAFewAreStored) {
  const double three = stored_m(3, true);
  EXPECT_GT(three, 2.5 * kWay);
  EXPECT_LT(stored_m(9, true), three + 0.5 * kWay);
}

// Nothing tells it that it is where it believes to be: the ground may be new.
TEST(CrowdedGround, ARobotThatIsNotTiedStoresWhatItDrivesOver) {
  EXPECT_GT(stored_m(9, false), 8.0 * kWay);
}

}  // namespace
}  // namespace gprodom
