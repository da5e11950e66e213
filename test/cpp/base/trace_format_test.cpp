#include "base/trace_format.h"

#include <gtest/gtest.h>

namespace gprodom {
namespace {

TEST(TraceFormat, RoundedSampleIntervalIsTheSameFormat) {
  const TraceFormat format{201, 2e-10};
  EXPECT_TRUE(same_format(format, {201, 2e-10}));
  EXPECT_TRUE(same_format(format, {201, 1.0 / 5e9}));
  EXPECT_TRUE(same_format(format, {201, 2.0000001e-10}));
  EXPECT_FALSE(same_format(format, {201, 2.0001e-10}));
  EXPECT_FALSE(same_format(format, {200, 2e-10}));
  EXPECT_TRUE(same_interval(format, {200, 2e-10}));
  EXPECT_FALSE(same_format({}, format));
}

}  // namespace
}  // namespace gprodom
