// A late wheel: which of the IMU's data, and which paths by the radar, belong to its distances.
#include "motion/late_wheel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "motion/slip/slip_belief.h"
#include "motion/wheel_delay.h"
#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kDelay_s = 0.43, kInterval_s = 0.2, kGravity = 9.80665;

// Stands for 4 s, sets off, and stands again from 30 to 34 s and from 60 s on.
double speed(double t) {
  const double on = std::min(t - 4, std::max(30 - t, t - 34)), off = 60 - t;
  return std::clamp(std::min(on, off), 0.0, 1.0) * (1.0 + 0.4 * std::sin(0.9 * t));
}

bool stands(double from, double to) { return speed(from) == 0.0 && speed(to) == 0.0; }

// A robot that drives along a straight line with a wheel that is late by kDelay_s, and the belief
// about its slip. l(t): ln(true distance / distance by the wheel).
class Drive {
 public:
  // told_s: the delay that is said to be learnt, from a time on.
  explicit Drive(double told_s, double from = 0.0) : told_s_(told_s), told_from_(from) {
    Config config;
    config.wheel.scale_sigma = 0.002;
    belief_.emplace(config);
    start_.covariance.diagonal().setConstant(1e-8);
  }

  template <typename Slip>
  void to(double end, Slip l) {
    while (now_ < end) {
      for (const double until = now_ + kInterval_s + kStep_s; sampled_ < until; sampled_ += kStep_s)
        sample(l);
      interval();
    }
  }

  bool tells() const { return !belief_->recent().empty(); }
  double told() const { return belief_->recent().back().l; }
  double told_sigma() const { return belief_->recent().back().sigma; }

 private:
  static constexpr double kStep_s = 0.01;

  template <typename Slip>
  void sample(Slip l) {
    const double t = sampled_, h = 1e-3, rolled = t - kDelay_s;
    const double acceleration = (speed(t + h) - speed(t - h)) / (2 * h);
    const double noise = kNoise.accel_density / std::sqrt(kStep_s);
    imu_.insert({from_seconds(t),
                 {acceleration + noise * normal_(), 0, kGravity},
                 Eigen::Vector3d::Zero()});
    wheel_.insert({from_seconds(t), wheel_m_});
    wheel_m_ += speed(rolled) * std::exp(-l(rolled)) * kStep_s;
  }

  void interval() {
    const TimeNs from = from_seconds(now_), to = from_seconds(now_ + kInterval_s);
    StateInput input;
    input.time = to;
    input.noise = kNoise;
    input.wheel_late = told_s_ > 0 && now_ >= told_from_;
    input.wheel_delay_s = input.wheel_late ? told_s_ : 0.0;
    input.steps = imu_.steps(from, to);
    input.has_wheel = set_wheel_distances(input.steps, wheel_, from, false);
    input.standing = stands(now_, now_ + kInterval_s);
    start_.state.v_odom.x() = speed(now_);
    if (late_.follow(input)) belief_->restart();
    if (!late_.waits())
      belief_->advance(late_.earlier(input, from, imu_, wheel_), start_, kNoise, 0.0);
    now_ += kInterval_s;
  }

  static constexpr ImuNoise kNoise{3e-4, 0.01};
  double told_s_, told_from_;
  LateWheel late_;
  ImuHistory imu_;
  WheelHistory wheel_{10.0};
  std::optional<SlipBelief> belief_;
  StateResult start_;
  double now_ = 1.0, sampled_ = 0.0, wheel_m_ = 0.0;
  Noise normal_{3};
};

double grips(double) { return 0.0; }
double slips(double t) { return -0.25 * std::clamp((t - 40) / 3, 0.0, 1.0); }

TEST(LateWheel, ThatGripsIsBelieved) {
  Drive drive(kDelay_s);
  for (double t = 10; t < 60; t += 2) {
    drive.to(t, grips);
    EXPECT_NEAR(drive.told(), 0.0, 0.02) << t;
  }
  Drive not_told(0.0);  // what it is late by looks like slip
  double most = 0.0;
  for (double t = 10; t < 60; t += 2) {
    not_told.to(t, grips);
    most = std::max(most, std::abs(not_told.told()));
  }
  EXPECT_GT(most, 0.04);
}

TEST(LateWheel, SaysNothingOfSlipUntilTheRobotStandsOnceItsDelayIsKnown) {
  Drive drive(kDelay_s, 20.0);
  drive.to(19.9, grips);
  EXPECT_TRUE(drive.tells());
  for (double t = 20.3; t < 30; t += 1) {
    drive.to(t, grips);
    EXPECT_FALSE(drive.tells()) << t;
  }
  drive.to(55, slips);
  EXPECT_NEAR(drive.told(), -0.25, 0.05);
  EXPECT_LT(drive.told_sigma(), 0.1);
}

TEST(LateWheel, TakesStandstillAndStepsOfTheTimeWhenItRolled) {
  ImuHistory imu;
  WheelHistory wheel(10.0);
  for (TimeNs i = 0; i <= 300; ++i) {
    const TimeNs time = i * 10'000'000;
    imu.insert({time, {0.01 * static_cast<double>(i), 0, kGravity}, Eigen::Vector3d::Zero()});
    wheel.insert({time, 0.001 * static_cast<double>(i * i)});
  }
  LateWheel late;
  int changes = 0;
  for (int k = 5; k < 14; ++k) {
    const TimeNs from = k * 200'000'000LL, to = from + 200'000'000;
    StateInput input;
    input.time = to;
    input.has_wheel = true;
    input.standing = k < 8;
    input.wheel_late = true;
    input.wheel_delay_s = k < 8 ? 0.4 : 0.7;
    input.steps = imu.steps(from, to);
    changes += late.follow(input);
    EXPECT_EQ(late.waits(), k < 6);  // it is found late, and is in use from the next standstill on
    if (late.waits()) continue;
    const StateInput earlier = late.earlier(input, from, imu, wheel);
    EXPECT_EQ(earlier.time, to);
    EXPECT_EQ(earlier.standing, k < 10);  // two intervals later
    double seconds = 0.0, wheel_m = 0.0, gained = 0.0;
    for (const MotionStep& step : earlier.steps) {
      seconds += step.dt;
      wheel_m += step.wheel_m;
      gained += step.acceleration.x() * step.dt;
    }
    const double begin = to_seconds(from) - 0.4, end = begin + 0.2;
    EXPECT_NEAR(seconds, 0.2, 1e-9);
    EXPECT_NEAR(gained, 0.5 * (end * end - begin * begin), 1e-6);
    EXPECT_NEAR(wheel_m, *wheel.distance(to) - *wheel.distance(from), 1e-9);
  }
  EXPECT_EQ(changes, 2);
}

TEST(LateWheel, APathByTheRadarWaitsUntilTheWheelHasReportedIt) {
  LateWheel late;
  StateInput input;
  input.standing = input.wheel_late = true;
  input.wheel_delay_s = 0.4;
  for (const double t : {-0.4, -0.2, 0.0}) {
    input.time = from_seconds(t);
    late.follow(input);
  }
  ASSERT_EQ(late.delay(), from_seconds(0.4));
  for (int i = 1; i <= 3; ++i) late.keep({from_seconds(i - 1), from_seconds(i), "radar"});
  EXPECT_TRUE(late.reported(from_seconds(1.3)).empty());
  const auto first = late.reported(from_seconds(1.5));
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].to, from_seconds(1));
  EXPECT_EQ(late.reported(from_seconds(10)).size(), 2u);
  EXPECT_TRUE(late.reported(from_seconds(10)).empty());
}

TEST(LateWheel, OnlyASlipBeyondItsDeviationCounts) {
  std::vector<IntervalSlip> slips = {{1, 0.02, 0.03}, {2, -0.2, 0.05}};
  keep_shown(slips);
  EXPECT_EQ(slips[0].l, 0.0);
  EXPECT_EQ(slips[0].sigma, 0.0);
  EXPECT_EQ(slips[1].l, -0.2);
  EXPECT_EQ(slips[1].sigma, 0.05);
}

// The delay of a wheel, from changes of speed, in the presence of noise, slip and bias.
struct Wheel {
  double late_s = 0.0, noise_mps = 0.0;
  double slipping = 0.0;   // of the time, for a second at once, half as fast again
  double accel_mps = 0.0;  // of the IMU's change of speed in an interval
};

// A minute of a robot that speeds up and slows down, more than one interval apart.
double shown(const Wheel& wheel) {
  WheelDelay delay;
  Noise n(1);
  const auto speed = [](double t) {
    return 1.0 + 0.4 * std::sin(1.3 * t) + 0.2 * std::sin(2.9 * t);
  };
  const auto reported = [&](double t) {
    const bool slips = std::fmod(t, 10.0) < 10.0 * wheel.slipping;
    return speed(t - wheel.late_s) * (slips ? 1.5 : 1.0) + wheel.noise_mps * n();
  };
  double imu = speed(0), by_wheel = reported(0);
  for (int k = 1; k < 300; ++k) {
    const double next = reported(k * kInterval_s);
    const double by_imu = speed(k * kInterval_s) - imu + wheel.accel_mps * n();
    delay.add(by_imu, next - by_wheel, kInterval_s);
    imu = speed(k * kInterval_s);
    by_wheel = next;
  }
  return delay.delay_s();
}

TEST(WheelDelay, IsFoundToAFractionOfAnInterval) {
  for (const double late_s : {0.12, 0.2, 0.33}) {
    EXPECT_NEAR(shown({late_s}), late_s, 0.04);
    const double in_noise = shown({late_s, 0.03, 0.0, 0.02});
    EXPECT_NEAR(in_noise, late_s, 0.05);
  }
}

// At a constant speed only noise can be compared; checked at each moment of two minutes.
TEST(WheelDelay, IsNotReportedAtAConstantSpeed) {
  constexpr int kDrives = 300;
  for (const double wheel_mps : {0.005, 0.01, 0.03}) {
    int told = 0;
    for (int seed = 0; seed < kDrives; ++seed) {
      WheelDelay delay;
      Noise n(seed);
      bool once = false;
      double before = 0.0;
      for (int k = 0; k < 600; ++k) {
        const double now = wheel_mps * n();
        delay.add(0.01 * n(), now - before, kInterval_s);
        before = now;
        once |= delay.delay_s() > 0.0;
      }
      told += once ? 1 : 0;
    }
    EXPECT_LE(told, 0.02 * kDrives) << wheel_mps;
  }
}

TEST(WheelDelay, NeitherNoiseNorSlipsAreADelay) {
  EXPECT_EQ(shown({}), 0.0);
  EXPECT_EQ(shown({0.0, 0.1}), 0.0);
  EXPECT_EQ(shown({0.0, 0.03, 0.3}), 0.0);
  EXPECT_EQ(shown({0.0, 0.0, 0.0, 0.1}), 0.0);
}

TEST(WheelDelay, IsNotReportedAtFirstNorAcrossBreaks) {
  WheelDelay delay;
  for (int k = 0; k < 1000; ++k) {
    delay.add(std::sin(0.3 * k), std::sin(0.3 * (k - 1)), kInterval_s);
    if (k % 5 == 0) delay.interrupt();
  }
  EXPECT_EQ(delay.delay_s(), 0.0);
}

}  // namespace
}  // namespace gprodom
