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

// A robot whose accelerometer has an error that lasts for two seconds.
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
  double slip = 0.0;       // m/s, of the wheel over the ground
  bool standing = false;   // as the detection of rest says
  double turn_rate = 0.0;  // rad/s
  double wheel_y_m = 0.0;  // configured is 0
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
      step.angular_velocity = {0, 0, turn_rate};
      step.wheel_m = (moved - wheel_y_m * turn_rate + slip) * dt;
      input.steps.push_back(step);
    }
    filter.advance(input, at_, {0.0, 0.0, kWhite});
    at_.state.q_odom_body = at_.state.q_odom_body * so3::exp({0, 0, turn_rate * kInterval});
    at_.state.v_odom = at_.state.q_odom_body * Eigen::Vector3d(speed, 0, 0);
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

  TimeNs now() const { return at_.state.time; }

  // A corner of 70 degrees every ten seconds, to the left and to the right; the speed changes too.
  void corners(double seconds) {
    for (double t = 0.0; t < seconds; t += kInterval) {
      const double phase = std::fmod(t, 20.0);
      turn_rate = phase > 2 && phase < 5 ? 0.4 : phase > 12 && phase < 15 ? -0.4 : 0.0;
      speed = 0.4 + 0.15 * std::sin(0.6 * t);
      next();
    }
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
      track.drive(1.6);
      EXPECT_GT(track.filter.slips(), 0.9) << seed;
      track.slip = 0.0;
      track.drive(0.6);
      EXPECT_LT(track.filter.slips(), 0.1) << seed;
    }
  }
}

TEST(GripFilter, TellsWhichIntervalsSlipped) {
  Track track(3);
  track.drive(20.0);
  track.slip = 0.5 * kSpeed;
  track.drive(1.0);
  track.slip = 0.0;
  track.drive(2.0);
  const TimeNs now = track.now();
  EXPECT_FALSE(track.filter.slipped(now - from_seconds(4.9), now - from_seconds(3.1)));
  for (double ago = 2.9; ago > 2.0; ago -= 0.2)
    EXPECT_TRUE(
        track.filter.slipped(now - from_seconds(ago), now - from_seconds(ago) + from_seconds(0.05)))
        << ago;
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

TEST(GripFilter, AWheelThatIsStuckSlips) {
  Track track(5);
  track.drive(20.0);
  track.slip = -kSpeed;
  track.drive(0.6);
  EXPECT_GT(track.filter.slips(), 0.9);
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
  EXPECT_GT(track.filter.slips(), 0.5);
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
}

TEST(GripFilter, BendsTellWhereTheWheelIs) {
  for (const double y : {-0.6, 0.0, 0.3}) {
    Track track(2, 0.01);
    track.wheel_y_m = y;
    track.corners(100.0);
    EXPECT_NEAR(track.filter.position().learnt().y_m, y, 0.05) << y;
    EXPECT_LT(track.filter.position().learnt().sigma_m, 0.05) << y;
    EXPECT_NEAR(track.filter.position().believed_m(), y, 0.05) << y;
    EXPECT_LT(track.filter.slips(), 0.1) << y;
  }
}

TEST(GripFilter, ErrorOfTheWheelsPositionIsNotLargerThanItSays) {
  constexpr int kTracks = 60;
  std::mt19937 engine(7);
  std::normal_distribution<double> prior(0.0, slip::WheelPosition({}).learnt().sigma_m);
  double sum = 0.0;
  for (unsigned i = 0; i < kTracks; ++i) {
    Track track(i, 0.05);
    track.wheel_y_m = prior(engine);
    track.corners(25.0);
    const slip::LearntPosition& told = track.filter.position().learnt();
    sum += std::pow((told.y_m - track.wheel_y_m) / told.sigma_m, 2);
  }
  EXPECT_GT(sum / kTracks, 0.1);  // two intervals count as one, so it says more
  EXPECT_LT(sum / kTracks, 1.6);
}

TEST(GripFilter, AWheelIsWhereItIsConfiguredUntilBendsSayOtherwise) {
  Track straight(4, 0.01);
  straight.wheel_y_m = -0.6;
  straight.drive(30.0, 0.005);
  EXPECT_NEAR(straight.filter.position().believed_m(), 0.0, 0.01);
  Config pair;
  pair.wheel.drive = WheelDrive::kDifferential;
  pair.wheel.lever_arm.y() = 0.1;
  EXPECT_FALSE(slip::WheelPosition(pair.wheel).learns());
  EXPECT_EQ(slip::WheelPosition(pair.wheel).believed_m(), 0.1);
  // Of an earlier run: that it is elsewhere is kept.
  slip::WheelPosition position{WheelConfig()};
  position.resume({-0.6, 0.1});
  EXPECT_NEAR(position.believed_m(), -0.6, 0.01);
  position.resume({-0.6, 2.0});  // less than is known anyway
  EXPECT_NEAR(position.learnt().sigma_m, 0.1, 0.01);
}

// Five centimetres are within what users measure, however surely they are learnt.
TEST(GripFilter, AnOffsetAsUsersMeasureWrongIsLeftAsConfigured) {
  slip::WheelPosition position{WheelConfig()};
  position.learn(0.06, 0.015);
  EXPECT_NEAR(position.believed_m(), 0.0, 0.01);
  position.learn(0.4, 0.015);
  EXPECT_NEAR(position.believed_m(), 0.4, 0.01);
}

TEST(GripFilter, IsOffWithoutAWheel) {
  Config config;
  config.wheel.enabled = false;
  Track track(1, 0.0, config);
  track.drive(5.0);
  track.slip = 5.0;
  track.drive(2.0);
  EXPECT_EQ(track.filter.slips(), 0.0);
}

}  // namespace
}  // namespace gprodom
