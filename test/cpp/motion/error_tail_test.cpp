#include "motion/slip/error_tail.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gprodom {
namespace {

// Errors size |z|^exponent standard deviations, of which a share has another, larger size.
double threshold_after(int count, double size, double exponent, double share = 0.0,
                       double larger = 0.0) {
  std::mt19937 engine(3);
  std::normal_distribution<double> z;
  std::uniform_real_distribution<double> slips;
  ErrorTail tail;
  for (int i = 0; i < count; ++i) {
    const double error =
        slips(engine) < share ? larger : size * std::pow(std::abs(z(engine)), exponent);
    tail.add(error * error);
  }
  return tail.threshold(5.0);
}

TEST(ErrorTail, NormalErrorsKeepTheThreshold) {
  EXPECT_EQ(ErrorTail().threshold(5.0), 5.0);
  EXPECT_LT(threshold_after(600, 1.0, 1.0), 6.0);
  EXPECT_EQ(threshold_after(600, 0.3, 1.0), 5.0);  // smaller than assumed: no less evidence
}

TEST(ErrorTail, HeavyTailsAndTooSmallADeviationRaiseIt) {
  EXPECT_NEAR(threshold_after(600, 3.0, 1.0), 15.0, 3.0);
  EXPECT_NEAR(threshold_after(600, 1.5, 2.0), 1.5 * 25.0, 10.0);
}

TEST(ErrorTail, SlipsInLessThanATenthOfTheIntervalsDoNotCount) {
  EXPECT_LT(threshold_after(600, 1.0, 1.0, 0.05, 30.0), 8.0);
}

// Wheel and IMU of a simulation may agree exactly.
TEST(ErrorTail, ErrorsOfZeroAndOnesThatAreNotFinite) {
  ErrorTail tail;
  for (int i = 0; i < 1000; ++i) tail.add(0.0);
  tail.add(std::nan(""));
  EXPECT_EQ(tail.threshold(5.0), 5.0);
}

}  // namespace
}  // namespace gprodom
