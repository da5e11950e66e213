#include "motion/slip/slip_share.h"

#include <gtest/gtest.h>

namespace gprodom::slip {
namespace {

TEST(SlipShare, IsLearntWhereSlipWouldBeSeen) {
  SlipShare share(0.3);
  EXPECT_DOUBLE_EQ(share.value(), 0.3);
  for (int i = 0; i < 600; ++i) share.add(1.0, i % 10 == 0 ? 1.0 : 0.0, 1.0);
  EXPECT_NEAR(share.value(), 0.11, 0.01);
}

// Where nothing would show slip, its probability stays low whatever the wheel does.
TEST(SlipShare, StaysWhereNoSlipWouldBeSeen) {
  SlipShare share(0.3);
  for (int i = 0; i < 600; ++i) share.add(1.0, 0.0, 0.01);
  EXPECT_GT(share.value(), 0.24);
}

TEST(SlipShare, AnEarlierRunCountsForTwoMinutes) {
  SlipShare before(0.3), share(0.3);
  for (int i = 0; i < 3600; ++i) before.add(1.0, 0.0, 1.0);
  share.take_up(before.counts());
  EXPECT_NEAR(share.value(), 0.3 * 30 / 150, 1e-9);
  for (int i = 0; i < 120; ++i) share.add(1.0, 1.0, 1.0);
  EXPECT_NEAR(share.value(), (0.3 * 30 + 120) / 270, 1e-9);
  share.take_up({0.0, 0.0});
  EXPECT_NEAR(share.value(), (0.3 * 30 + 120) / 270, 1e-9);
}

}  // namespace
}  // namespace gprodom::slip
