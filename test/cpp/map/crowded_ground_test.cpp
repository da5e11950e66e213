// A robot that drives the same way again and again, over ground that looks different to it each
// time: it wanders, and what lies aside is another ground to the antenna.
#include "map/crowded_ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "driven_ground.h"
#include "gpr/synthetic_ground.h"
#include "map/mapper.h"
#include "straight_robot.h"

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

// That the state is where one of the first pass was.
Displacement seen_again(int state) {
  const int before = static_cast<int>(std::lround(place_at(state) / kStep));
  const bool mirrored = state / kStates % 2 == 1;  // by the direction of driving
  return gprodom::seen_again(time_of(before), time_of(state), mirrored);
}

// What is stored after so many passes.
GroundMap ground_after(int passes, bool tied) {
  Mapper mapper(default_config(), std::nullopt, std::nullopt);
  gpr::SyntheticRadar radar(1, 60.0);
  for (int pass = 0; pass < passes; ++pass) {
    const gpr::SyntheticGround there(static_cast<unsigned>(pass) + 1, kWay);
    MapInput input;
    for (int i = pass * kStates; i < (pass + 1) * kStates; ++i) {
      input.states.push_back(state_at(time_of(i), place_at(i), 1e-8 * i));
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
  return mapper.take_ground();
}

double stored_after(int passes, bool tied) { return stored_m(ground_after(passes, tied).memory); }

TEST(CrowdedGround, OfManyPassesSideBySideAFewAreStored) {
  const double three = stored_after(3, true);
  EXPECT_GT(three, 2.5 * kWay);
  EXPECT_LT(stored_after(9, true), three + 0.5 * kWay);
}

// Nothing tells it that it is where it believes to be: the ground may be new.
TEST(CrowdedGround, ARobotThatIsNotTiedStoresWhatItDrivesOver) {
  EXPECT_GT(stored_after(9, false), 8.0 * kWay);
}

// The next track knows how they lie: those beside which there are three older ones go.
TEST(CrowdedGround, OfWhatWasStoredUntiedTheNextTrackKeepsThreePasses) {
  const GroundMap all = ground_after(9, false);
  Mapper next(default_config(), all, std::nullopt);
  const GroundMap kept = next.take_ground();
  EXPECT_NEAR(stored_m(kept.memory), 3.0 * kWay, 0.2 * kWay);
  for (const KnownPlace& place : kept.places) {
    const auto older = std::find_if(all.places.begin(), all.places.end(), [&](const auto& other) {
      return all.memory.column(other.column).time == kept.memory.column(place.column).time;
    });
    ASSERT_NE(older, all.places.end());
    EXPECT_EQ(place.pose.p, older->pose.p);
  }
  ASSERT_FALSE(all.descent.empty());
  const GroundHead now{1, kept.format, true, kept.descent}, file{2, all.format, true, all.descent};
  EXPECT_TRUE(descends(now, file));
  EXPECT_EQ(stored_m(without_crowded(kept, 0.15).memory), stored_m(kept.memory));
}

// The robot has left the lane that it drove again and again, for one 30 cm aside.
TEST(CrowdedGround, ANewLaneBesideAnOldOneStays) {
  GroundMap ground = ground_after(5, false);
  for (KnownPlace& place : ground.places)
    if (place.column / 1500 == 4) place.pose.p.y() += 0.3;
  const GroundMap kept = without_crowded(ground, 0.15);
  EXPECT_NEAR(stored_m(kept.memory), 4.0 * kWay, 0.2 * kWay);
  EXPECT_NEAR(kept.places.back().pose.p.y(), 0.3, 0.01);
}

// A pass a metre aside, and one of another map, are no passes beside.
TEST(CrowdedGround, WhatLiesElsewhereStays) {
  GroundMap ground = ground_after(5, false);
  const double stored = stored_m(ground.memory);
  int pass = 0;
  for (KnownPlace& place : ground.places) {
    pass = std::max(pass, static_cast<int>(place.column / 1500));
    if (pass == 2) place.pose.p.y() += 1.0;
    if (pass == 3) place.map = 1;
  }
  EXPECT_EQ(stored_m(without_crowded(std::move(ground), 0.15).memory), stored);
}

// A robot that comes back beside the way just driven.
constexpr double kOut = 12.0;  // m

double place_there(double way) { return way < kOut ? way : 2 * kOut - way; }

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
    input.states.push_back(
        state_at(from_seconds(1000.0 + 0.2 * i), place_there(kStep * i), 1e-8 * i));
    for (int k = 1 - kTraces; k <= 0 && i > 0; ++k) {
      const double at = i + static_cast<double>(k) / kTraces, place = place_there(kStep * at);
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
  outcome.stored_m = stored_m(mapper.take_ground().memory);
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
