// A wheel of which accelerations show the scale only while the accelerometer's axes are known.
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/driven_intervals.h"

namespace gprodom {
namespace {

constexpr double kTrueScale = 1.02, kScaleSigma = 0.02;

// A robot on a straight line, now faster, now slower.
class Drive {
 public:
  // forwards: what the accelerometer's x has for sign. density: what its noise is taken for.
  StateResult go_on(double seconds, bool axes_known, double forwards, double density) {
    StateResult result;
    for (double end = now_s_ + seconds; now_s_ < end - 0.5 * kStateInterval;) {
      StateInput input = interval(now_s_, {}, noise_);
      input.noise = {1.6e-4, density};
      input.axes_known = axes_known;
      for (MotionStep& step : input.steps) {
        const double push = 0.4 * std::cos(now_s_);
        step.acceleration.x() += forwards * push;
        step.wheel_m = kTrueScale * (speed_ + 0.5 * push * step.dt) * step.dt;
        speed_ += push * step.dt;
        now_s_ += step.dt;
      }
      result = estimator_.add(input);
    }
    return result;
  }

 private:
  Noise noise_{1};
  double now_s_ = 10.0, speed_ = 0.8 - 0.4 * std::sin(10.0);
  StateEstimator estimator_ = at_ten_seconds(0.8, kScaleSigma);
};

double scale_sigma(const StateResult& result) { return sigma(result, row::kScale); }

// A wrong sign, with errors as large as the accelerations: the scale would come out wrong.
TEST(HeldScale, AccelerationsAlongUnknownAxesDoNotShowIt) {
  Drive drive;
  const StateResult unknown = drive.go_on(60.0, false, -1.0, 0.5);
  EXPECT_NEAR(unknown.state.wheel_scale, 1.0, 1e-5);
  EXPECT_NEAR(scale_sigma(unknown), kScaleSigma, 1e-4);
}

TEST(HeldScale, OnceTheAxesAreKnownTheyShowIt) {
  Drive drive;
  const StateResult before = drive.go_on(20.0, false, 1.0, 0.5);
  const double off_m = before.state.p_odom.x() * (kTrueScale - 1);
  EXPECT_NEAR(std::sqrt(before.covariance(row::kP, row::kP)), std::abs(off_m), 0.2 * off_m);
  const StateResult known = drive.go_on(60.0, true, 1.0, 2e-3);
  EXPECT_LT(scale_sigma(known), 0.25 * kScaleSigma);
  EXPECT_NEAR(known.state.wheel_scale, kTrueScale, 3 * scale_sigma(known));
}

}  // namespace
}  // namespace gprodom
