#include "input/trace_format_watch.h"

#include <gtest/gtest.h>

namespace gprodom {
namespace {

GprTrace trace(std::size_t samples, double interval_s) {
  GprTrace t;
  t.samples.assign(samples, 1.0f);
  t.sample_interval_s = interval_s;
  return t;
}

TEST(TraceFormatWatch, SingleOddTraceIsDroppedAndANewSettingIsFollowed) {
  TraceFormatWatch format;
  EXPECT_EQ(format.check(trace(201, 2e-10)), "");
  for (int i = 0; i < 20; ++i) {
    EXPECT_NE(format.check(trace(181, 2e-10)), "");
    EXPECT_NE(format.check(trace(201, 3e-10)), "");
    EXPECT_EQ(format.check(trace(201, 2e-10)), "");
  }
  int dropped = 0;
  while (!format.check(trace(181, 2e-10)).empty()) ++dropped;
  EXPECT_EQ(dropped, 4);
  EXPECT_NE(format.check(trace(201, 2e-10)), "");
}

// The first trace may be the damaged one: it must not say which ground is stored.
TEST(TraceFormatWatch, SettingCountsOnceSeveralTracesAgree) {
  TraceFormatWatch format;
  format.check(trace(181, 2e-10));
  EXPECT_FALSE(format.agreed());
  for (int i = 0; i < 4; ++i) {
    format.check(trace(201, 2e-10));
    EXPECT_FALSE(format.agreed());
  }
  EXPECT_EQ(format.check(trace(201, 2e-10)), "");
  ASSERT_TRUE(format.agreed());
  EXPECT_EQ(format.agreed()->samples, 201U);
  format.check(trace(181, 2e-10));
  EXPECT_EQ(format.agreed()->samples, 201U);
}

TEST(TraceFormatWatch, SettingIsKnownThoughEveryOtherTraceIsDamaged) {
  TraceFormatWatch format;
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_FALSE(format.agreed());
    format.check(trace(201, 2e-10));
    format.check(trace(100 + i, 2e-10));
  }
  EXPECT_EQ(format.agreed()->samples, 201U);
}

}  // namespace
}  // namespace gprodom
