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
    gpr::PathLength path;
    path.from = from_seconds(10 + t - 1);
    path.to = from_seconds(10 + t);
    path.valid = true;
    path.lengths = kSpeed / drive.metres_per_length(t) * std::exp(drive.spread * normal());
    const Displacement metres = scale.to_metres(path);
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
  CoherenceScale scale;
  auto metres = [&scale, second = 0](int unit, double lengths) mutable {
    for (int i = 0; i < 200; ++i) {
      OdometryEstimate estimate;
      estimate.time = from_seconds(second + 0.005 * (i + 1));
      estimate.v_body.x() = kSpeed;
      scale.add(estimate, true);
    }
    gpr::PathLength path;
    path.from = from_seconds(second);
    path.to = from_seconds(++second);
    path.valid = true;
    path.unit = unit;
    path.lengths = lengths;
    return scale.to_metres(path);
  };
  for (int i = 0; i < 40; ++i) metres(1, 4.0);
  EXPECT_NEAR(metres(1, 4.0).distance_m, kSpeed, 1e-3);
  EXPECT_FALSE(metres(2, 12.0).valid) << "not learnt yet";
  for (int i = 0; i < 40; ++i) metres(2, 12.0);
  const Displacement again = metres(2, 12.0);
  EXPECT_TRUE(again.valid);
  EXPECT_NEAR(again.distance_m, kSpeed, 1e-3);
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
