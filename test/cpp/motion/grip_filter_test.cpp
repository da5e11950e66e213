// A wheel that slips is told from an accelerometer that errs, and neither is silenced by a guess.
#include "motion/grip_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "motion/radar_finding.h"

namespace gprodom {
namespace {

constexpr double kInterval = 0.2;  // s
constexpr int kSteps = 20;         // of the IMU, in each
constexpr double kSpeed = 0.5;     // m/s

// A robot along a straight line. Its accelerometer has an error that lasts for two seconds.
class Track {
 public:
  explicit Track(unsigned seed, double error_mps2 = 0.0, const Config& config = {})
      : filter(config), error_size_(error_mps2), random_(seed) {
    at_.state.time = from_seconds(100.0);
    at_.state.v_odom.x() = kSpeed;
    at_.covariance = 1e-6 * StateMatrix::Identity();
  }

  GripFilter filter;
  double speed = kSpeed;
  double slip = 0.0;      // m/s, of the wheel over the ground
  bool standing = false;  // as the detection of rest says
  bool imu_gap = false;

  void next() {
    StateInput input;
    input.time = at_.state.time + from_seconds(kInterval);
    input.noise = {2e-4, kWhite, 0.0};
    input.has_wheel = true;
    input.standing = standing;
    const double dt = kInterval / kSteps, before = last_speed_, kept = std::exp(-dt / 2.0);
    last_speed_ = speed;
    for (int k = 0; k < kSteps; ++k) {
      error_ = kept * error_ + error_size_ * std::sqrt(1 - kept * kept) * normal_(random_);
      MotionStep step{};
      step.dt = dt;
      step.bridged = step.long_gap = imu_gap;
      const double white = kWhite / std::sqrt(dt) * normal_(random_);
      step.acceleration = {(speed - before) / kInterval + error_ + white, 0, kStandardGravity};
      const double moved = before + (speed - before) * (k + 0.5) / kSteps;
      step.wheel_m = (moved + slip) * dt;
      input.steps.push_back(step);
    }
    filter.advance(input, at_, {0.0, 0.0, kWhite});
    at_.state.time = input.time;
  }

  // Share of the intervals in which slip is more likely than not.
  double drive(double seconds, double acceleration = 0.0) {
    int flagged = 0;
    const int n = static_cast<int>(std::lround(seconds / kInterval));
    for (int i = 0; i < n; ++i) {
      speed += acceleration * kInterval;
      next();
      flagged += filter.slips() > 0.5;
    }
    return static_cast<double>(flagged) / n;
  }

  Displacement radar(double metres) const {
    const double now = to_seconds(at_.state.time);
    gpr::PathLength path;
    path.from = from_seconds(now - 1.0);
    path.to = from_seconds(now);
    path.lengths = metres;
    path.valid = true;
    Displacement d = to_displacement(path, 1.0);
    d.sigma_m = 0.1 * metres;
    return d;
  }

 private:
  static constexpr double kWhite = 2e-3;  // m/s^2/sqrt(Hz)

  StateResult at_;
  double error_size_, error_ = 0.0, last_speed_ = kSpeed;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

TEST(GripFilter, AJumpOfTheWheelIsSlipWithinAFewIntervalsAndItsEndToo) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const double slip : {0.5, -0.5}) {
      Track track(seed);
      EXPECT_EQ(track.drive(30.0), 0.0) << seed;
      track.slip = slip * kSpeed;
      track.drive(0.4);
      EXPECT_GT(track.filter.slips(), 0.9) << seed;
      EXPECT_EQ(track.filter.wheel_is_fast(), slip > 0);
      track.drive(1.6);
      EXPECT_GT(track.filter.slips(), 0.9) << seed;
      EXPECT_NEAR(*track.filter.ground_m(), kSpeed * kInterval, 0.1 * kSpeed * kInterval);
      track.slip = 0.0;
      track.drive(0.6);
      EXPECT_LT(track.filter.slips(), 0.1) << seed;
    }
  }
}

TEST(GripFilter, TheIntervalsOfASlipAreLooseAndNoOthers) {
  Track track(3);
  track.drive(20.0);
  track.slip = 0.5 * kSpeed;
  track.drive(1.0);
  track.slip = 0.0;
  track.drive(2.0);
  const std::vector<LooseWheel> loose = track.filter.loose();
  ASSERT_EQ(loose.size(), 25u);
  for (std::size_t k = 0; k < loose.size(); ++k) {
    const bool slipped = k >= 10 && k < 15;  // of the last five seconds
    if (slipped)
      EXPECT_GT(loose[k].sigma_m, 0.01) << k;
    else
      EXPECT_LT(loose[k].sigma_m, 0.002) << k;
  }
  const TimeNs now = loose.back().to;
  EXPECT_TRUE(track.filter.slipped(now - from_seconds(3.0), now - from_seconds(2.1)));
  EXPECT_FALSE(track.filter.slipped(now - from_seconds(1.9), now));
}

// The wheel is right all the time. A fixed threshold on the IMU's noise would cry slip.
TEST(GripFilter, AnAccelerometerThatErrsIsNoSlip) {
  for (const double error : {0.05, 0.2, 1.0}) {
    double flagged = 0.0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      Track track(seed, error);
      for (int leg = 0; leg < 10; ++leg) {
        flagged += track.drive(4.0, leg % 2 == 0 ? 0.1 : -0.1);
        flagged += track.drive(2.0);
      }
    }
    EXPECT_LT(flagged / 200, 0.01) << error;
  }
}

TEST(GripFilter, TheSizeOfTheErrorIsLearnt) {
  for (const double error : {0.06, 0.5}) {
    Track track(1, error);
    track.drive(120.0);
    const double size = track.filter.error_density();  // over one second
    EXPECT_GT(size, error / 3) << error;
    EXPECT_LT(size, error * 3) << error;
  }
}

TEST(GripFilter, AWheelThatIsStuckSlips) {
  Track track(5);
  track.drive(20.0);
  track.slip = -kSpeed;
  track.drive(0.6);
  EXPECT_GT(track.filter.slips(), 0.9);
  EXPECT_FALSE(track.filter.wheel_is_fast());
  EXPECT_GT(track.filter.loose().back().sigma_m, 0.01);
}

// After a gap the speed is not known, so the wheel's is taken, until the radar knows better.
TEST(GripFilter, AfterAGapOfTheImuTheRadarTells) {
  Track track(7);
  track.drive(20.0);
  track.imu_gap = true;
  track.slip = kSpeed;
  track.drive(1.0);
  track.imu_gap = false;
  track.drive(1.2);
  EXPECT_LT(track.filter.slips(), 0.5);
  for (int i = 0; i < 3; ++i) {
    track.filter.compare(track.radar(kSpeed));
    track.drive(1.0);
  }
  EXPECT_NEAR(*track.filter.ground_m(), kSpeed * kInterval, 0.3 * kSpeed * kInterval);
}

TEST(GripFilter, AStandstillEndsAllDoubt) {
  Track track(9);
  track.drive(20.0);
  track.slip = 0.5 * kSpeed;
  track.drive(1.0);
  track.slip = 0.0;
  track.speed = 0.0;
  track.next();
  track.standing = true;
  track.drive(1.0);
  EXPECT_EQ(track.filter.slips(), 0.0);
  EXPECT_NEAR(*track.filter.ground_m(), 0.0, 1e-3);
}

TEST(GripFilter, IsOffWithoutAThresholdOrAWheel) {
  Config config;
  config.wheel.slip_threshold = 0;
  Track track(1, 0.0, config);
  track.drive(5.0);
  track.slip = 5.0;
  track.drive(2.0);
  EXPECT_EQ(track.filter.slips(), 0.0);
  EXPECT_TRUE(track.filter.loose().empty());
  EXPECT_FALSE(track.filter.ground_m());
}

}  // namespace
}  // namespace gprodom
