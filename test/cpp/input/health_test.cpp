#include "input/health.h"

#include <gtest/gtest.h>

namespace gprodom {
namespace {

using Warnings = std::vector<std::string>;

TEST(Health, EndOfAConditionIsReportedWithItsText) {
  Health health(10.0);
  health.set("WHEEL", HealthLevel::kDegraded, "no data for a second or more");
  EXPECT_EQ(health.take_warnings(), Warnings{"WHEEL: no data for a second or more"});
  EXPECT_EQ(health.status(1).reasons, Warnings{"WHEEL: no data for a second or more"});
  health.set("WHEEL", HealthLevel::kDegraded, "");
  EXPECT_EQ(health.take_warnings(), Warnings{"WHEEL: over: no data for a second or more"});
  EXPECT_TRUE(health.status(2).reasons.empty());
}

TEST(Health, AwaitedConditionBeginsAndEndsWithoutAWarning) {
  Health health(10.0);
  health.await("start", HealthLevel::kDegraded, "collecting");
  health.set("start", HealthLevel::kDegraded, "");
  EXPECT_TRUE(health.take_warnings().empty());
}

}  // namespace
}  // namespace gprodom
