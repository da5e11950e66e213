// A wheel of which accelerations show the scale only while the accelerometer's axes are known.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimation/state_estimator.h"

namespace gprodom {
namespace {

constexpr double kInterval_s = 0.2, kSample_s = 0.01;
constexpr double kTrueScale = 1.02, kScaleSigma = 0.02;

// A robot on a straight line, now faster, now slower.
class Drive {
 public:
  Drive() : estimator_(Config{}, initial()) {}

  // forwards: what the accelerometer's x has for sign. density: what its noise is taken for.
  StateResult go_on(double seconds, bool axes_known, double forwards, double density) {
    StateResult result;
    for (double end = now_s_ + seconds; now_s_ < end - 0.5 * kInterval_s;) {
      StateInput input;
      input.noise = {1.6e-4, density};
      input.axes_known = axes_known;
      input.has_wheel = true;
      for (int i = 0; i < kInterval_s / kSample_s - 0.5; ++i) {
        const double push = 0.4 * std::cos(now_s_);
        MotionStep step;
        step.dt = kSample_s;
        step.acceleration =
            Eigen::Vector3d(forwards * push + 6e-3 * noise_(random_), 0, kStandardGravity);
        step.wheel_m = kTrueScale * (speed_ + 0.5 * push * kSample_s) * kSample_s;
        speed_ += push * kSample_s;
        now_s_ += kSample_s;
        input.steps.push_back(step);
      }
      input.time = from_seconds(now_s_);
      result = estimator_.add(input);
    }
    return result;
  }

 private:
  static InitialState initial() {
    InitialState initial;
    initial.state.time = from_seconds(10.0);
    initial.state.v_odom.x() = 0.8;
    initial.noise = {1.6e-4, 6e-4};
    StateMatrix covariance = 1e-6 * StateMatrix::Identity();
    covariance(row::kScale, row::kScale) = kScaleSigma * kScaleSigma;
    initial.prior = gaussian_prior(initial.state, covariance);
    return initial;
  }

  std::mt19937 random_{1};
  std::normal_distribution<double> noise_;
  double now_s_ = 10.0, speed_ = 0.8 - 0.4 * std::sin(10.0);
  StateEstimator estimator_;
};

double scale_sigma(const StateResult& result) {
  return std::sqrt(result.covariance(row::kScale, row::kScale));
}

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
