#include "map/pass_finder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gprodom {
namespace {

// Five laps of a square of 10 m a side, each a little further to the left.
TEST(PassFinder, NearestAndNewestPassComeFirst) {
  const PlanarPose here{{5.0, 0.1}, 0.0};
  PassFinder finder(here, 1.0, 0.5, 0.0);
  std::size_t place = 0;
  for (const double aside : {0.0, 0.09, 0.02, 0.04, 0.35}) {
    for (int i = 0; i < 20; ++i) finder.offer(place++, {{0.5 * i, aside}, 0.0}, false);
    for (int i = 0; i < 20; ++i) finder.offer(place++, {{10.0, 0.5 * i}, 1.57}, false);
  }
  ASSERT_EQ(finder.passes().size(), 5U);
  const auto order = in_search_order(finder.passes(), 0.15);
  ASSERT_EQ(order.size(), 5U);
  EXPECT_EQ(order[0].place, 50U);   // 1 cm aside
  EXPECT_EQ(order[1].place, 130U);  // the newest but for the one 25 cm aside
  EXPECT_EQ(order[4].place, 170U);
}

TEST(PassFinder, PassInTheOppositeDirectionIsTurned) {
  for (const bool turned : {false, true}) {
    PassFinder finder({{1.0, 0.0}, 0.1}, 1.0, 0.5, 0.0);
    finder.offer(0, {{1.2, 0.1}, turned ? M_PI : 0.0}, false);
    ASSERT_EQ(finder.passes().size(), 1U);
    EXPECT_EQ(finder.passes()[0].turned, turned);
    EXPECT_NEAR(finder.passes()[0].along, turned ? 0.2 : -0.2, 1e-9);
  }
}

}  // namespace
}  // namespace gprodom
