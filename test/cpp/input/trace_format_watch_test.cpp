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

}  // namespace
}  // namespace gprodom
