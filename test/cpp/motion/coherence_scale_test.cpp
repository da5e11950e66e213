#include "motion/coherence_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kSpeed = 0.4;  // m/s

struct Answer {
  double time, distance_m, sigma_m;
  bool valid;
};

// A robot at kSpeed; each span of 1 s errs by a factor exp(spread * normal). What holds at each
// time:
struct Drive {
  unsigned seed;
  int seconds;
  double spread;
  std::function<double(double)> metres_per_length = [](double) { return 0.06; };  // of the ground
  std::function<std::int32_t(double)> flags = [](double) { return 0; };
  std::function<double(double)> seen = [](double) { return 1.0; };  // published speed over true
  std::function<bool(double)> speed_known = [](double) { return true; };
  std::function<int(double)> unit = [](double) { return 0; };
};

std::vector<Answer> driven(const Drive& drive) {
  Noise normal(drive.seed);
  CoherenceScale scale;
  std::vector<Answer> answers;
  for (int i = 0; i <= drive.seconds * 200; ++i) {
    const double t = i * 0.005;
    OdometryEstimate estimate;
    estimate.time = from_seconds(10 + t);
    estimate.v_body.x() = kSpeed * drive.seen(t);
    estimate.flags = drive.flags(t);
    scale.add(estimate, drive.speed_known(t));
    if (i == 0 || i % 200 != 0) continue;
    const double lengths = kSpeed / drive.metres_per_length(t) * std::exp(drive.spread * normal());
    const Displacement metres = scale.to_metres(
        {from_seconds(9 + t), estimate.time, "radar", true, lengths, 1.0, drive.unit(t)});
    answers.push_back({t, metres.distance_m, metres.sigma_m, metres.valid});
  }
  return answers;
}

TEST(CoherenceScale, VarianceIsThatOfTheErrors) {
  for (const double spread : {0.08, 0.15, 0.3}) {
    double squares = 0, n = 0;
    for (unsigned seed = 0; seed < 100; ++seed)
      for (const Answer& a : driven({seed, 120, spread}))
        if (a.time > 60) {
          ASSERT_TRUE(a.valid);
          squares += std::pow((a.distance_m - kSpeed) / a.sigma_m, 2);
          ++n;
        }
    // The errors of spans are independent here, and the reported variance is doubled.
    EXPECT_GT(squares / n, 0.3) << spread;
    EXPECT_LT(squares / n, 0.7) << spread;
  }
}

TEST(CoherenceScale, HasALargeVarianceAtFirstAndNoValueBeforeLearning) {
  const auto answers = driven({1, 60, 0.1});
  EXPECT_FALSE(answers[2].valid);
  EXPECT_TRUE(answers[12].valid);
  EXPECT_GT(answers[12].sigma_m, 1.3 * answers[58].sigma_m);
}

TEST(CoherenceScale, FollowsTheGround) {
  const auto answers = driven({2, 120, 0.05, [](double t) { return t < 60 ? 0.06 : 0.03; }});
  EXPECT_NEAR(answers[58].distance_m, kSpeed, 0.06);
  EXPECT_NEAR(answers[118].distance_m, kSpeed, 0.06);
  EXPECT_GT(answers[64].sigma_m, 2 * answers[58].sigma_m);  // the jump was not foreseen
}

TEST(CoherenceScale, BeginsAnewWithAnotherUnit) {
  Drive drive{1, 84, 0.0};
  drive.unit = [](double t) { return t <= 41 ? 1 : 2; };
  drive.metres_per_length = [&](double t) { return drive.unit(t) == 1 ? 0.1 : kSpeed / 12; };
  const auto answers = driven(drive);
  EXPECT_NEAR(answers[40].distance_m, kSpeed, 1e-3);
  EXPECT_FALSE(answers[41].valid) << "not learnt yet";
  EXPECT_TRUE(answers.back().valid);
  EXPECT_NEAR(answers.back().distance_m, kSpeed, 1e-3);
}

// The published speed is wrong from 60 s on; a slip is flagged up to half a second late.
TEST(CoherenceScale, LearnsNothingFromASlipNorFromASpeedThatIsNotKnown) {
  Drive slips{3, 90, 0.05};
  slips.seen = [](double t) { return t > 60 ? 1.8 : 1.0; };
  Drive unknown = slips;
  slips.flags = [](double t) { return t > 60.4 && t < 90 ? kSlipping : 0; };
  unknown.speed_known = [](double t) { return t <= 60; };
  for (const Drive& drive : {slips, unknown}) {
    const auto answers = driven(drive);
    for (const Answer& a : answers) {
      if (a.time <= 20) continue;
      EXPECT_NEAR(a.distance_m, kSpeed, 0.08) << a.time;
    }
    // The variance grows with distance.
    EXPECT_GT(answers[88].sigma_m, 1.15 * answers[62].sigma_m);
  }
}

}  // namespace
}  // namespace gprodom
