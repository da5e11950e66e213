#include "map/locator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "driven_ground.h"
#include "map/change_follower.h"

namespace gprodom {
namespace {

constexpr std::size_t kPatch = 92;  // columns
const PlanarPose kAntenna{{kAntennaAhead, 0.0}, 0.0};

GroundMap known_ground() {
  GroundMap ground{gpr::TraceMemoryOptions()};
  drive(ground, 3, 1.0, 21.0);
  return reloaded(ground);
}

// A map of 20 m of ground, and 9 m of it driven again where waves are slower.
class ChangedGround : public ::testing::TestWithParam<double> {
 protected:
  ChangedGround() {
    before = ground.memory.kept().end;
    const std::size_t places = ground.places.size();
    drive(ground, 3, 6.0, 15.0, 5, 1e8 / std::exp(GetParam()));
    ground.places.resize(places);  // where the new ground lies is not known
  }

  GroundMap ground = known_ground();
  std::size_t before = 0;  // columns of the map
};

// At a stretch between those that the search tries.
TEST_P(ChangedGround, IsFoundAnywhereWithItsStretch) {
  Locator locator;
  const double newest = Locator::last_searched(ground.memory, before)->distance_m;
  const PlanarPose body{{newest - kAntennaAhead, 1.0}, 0.0};
  auto found = locator.find(ground, before, body, kAntenna, 9.0);
  if (!found)
    found = locator.find(ground, before, body, kAntenna, 10.0);  // other stretches are tried
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->change.stretch, GetParam(), 0.015);
  EXPECT_NEAR(found->change.turn, 0.0, 0.9);
  EXPECT_NEAR(found->map_from_track.p.x(), 0.0, 0.3);
}

TEST_P(ChangedGround, ItsStretchIsFoundNearAPlace) {
  const auto near = Locator::change_near(ground, before, {0, {14.0, 1.0}, 1.5});
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->stretch, GetParam(), 0.025);
  EXPECT_FALSE(Locator::change_near(ground, before, {0, {14.0, 60.0}, 1.5}));
  EXPECT_FALSE(Locator::change_near(ground, before, {1, {14.0, 1.0}, 1.5}));
}

// The turn takes up what the direct wave, from which times are counted, is off; what counts is that
// the ground fits as well as with the true stretch.
TEST_P(ChangedGround, IsFollowedFromAStretchNearby) {
  const gpr::TraceMemory& memory = ground.memory;
  gpr::PatchMatcher matcher(*memory.filter(), memory.spacing());
  ChangeFollower follower;
  follower.believe({GetParam() + 0.03, 0.4});
  double fits = 0.0, with_truth = 0.0;
  for (std::size_t first = before; first + kPatch <= memory.kept().end; first += 12) {
    const auto query = [&](const gpr::TraceChange& change) {
      return memory.patch({first, first + kPatch}, change);
    };
    const double there = memory.column(first).distance_m - memory.column(0).distance_m;
    const double column = there / memory.spacing() + 0.5 * (kPatch - 1);
    follower.follow(memory, column, query);
    if (first < before + 250) continue;  // it has come near by then
    const auto at = static_cast<std::size_t>(column);
    const gpr::Columns near = memory.patch({at - kPatch, at + kPatch});
    fits += matcher.match(near, query(follower.change()), 0.0, 0.1).correlation;
    with_truth += matcher.match(near, query({GetParam(), 0.0}), 0.0, 0.1).correlation;
  }
  EXPECT_NEAR(follower.change().stretch, GetParam(), 0.015);
  EXPECT_GT(fits, 0.95 * with_truth);
}

// After the shortest query and what is left to prove a place: the first search is for the likely
// changes, and an earlier one is not made.
TEST(Locator, SearchesAsSoonAsThereIsGroundEnough) {
  GroundMap ground = known_ground();
  const std::size_t before = ground.memory.kept().end;
  Locator locator;
  drive(ground, 3, 6.0, 13.5, 5, 1e8, true);
  EXPECT_FALSE(locator.find(ground, before, {}, kAntenna, 6.0));
  EXPECT_TRUE(locator.is_due(6.0));
  drive(ground, 3, 13.5, 14.3, 6, 1e8, true);
  const double newest = Locator::last_searched(ground.memory, before)->distance_m;
  EXPECT_NEAR(newest, 12.3, 0.05);
  const auto found =
      locator.find(ground, before, {{newest - kAntennaAhead, 1.0}, 0.0}, kAntenna, 6.3);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->map_from_track.p.x(), 0.0, 0.3);
  EXPECT_FALSE(locator.is_due(6.4));
}

// Of few columns as of all. None of them is stored yet, which rounds them.
TEST(Locator, AChangeIsUndoneInFewColumnsAsInAll) {
  GroundMap ground = known_ground();
  drive(ground, 3, 6.0, 12.0, 5, 1e8, true);
  const gpr::TraceChange change{0.05, 0.4};
  const gpr::Columns all = ground.memory.newest_ground(40, change);
  const gpr::Columns newest = ground.memory.newest(20, 20, change)->features;
  ASSERT_EQ(newest.rows(), 40);
  EXPECT_LT((newest - all).cwiseAbs().maxCoeff(), 1e-4F * all.cwiseAbs().maxCoeff());
}

INSTANTIATE_TEST_SUITE_P(Stretches, ChangedGround, ::testing::Values(-0.07, 0.0, 0.03, 0.1));

}  // namespace
}  // namespace gprodom
