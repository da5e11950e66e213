// The size of a gyro's bias, from a drive of four seconds over uneven ground with bends.
#include "motion/gyro_bias_size.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;

struct Drive {
  Vector3d bias = Vector3d::Zero();  // rad/s
  double vibration = 0.0;            // m/s^2, of single samples at 100 Hz
  double slope = 0.0;                // rad, amplitude of roll and pitch
  double slip = 0.0;                 // of the wheel, from 1.5 s to 2.5 s
};

GyroBiasSize size_of(const Drive& drive, unsigned seed) {
  Noise n(seed);
  const auto speed = [](double t) { return 1.0 + 0.3 * std::sin(1.5 * t); };
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 400; ++i) {
    const double t = i * 0.01, turning = 0.4 * std::cos(t);
    const double roll = drive.slope * std::sin(1.1 * t), pitch = drive.slope * std::cos(0.8 * t);
    const double roll_rate = 1.1 * drive.slope * std::cos(1.1 * t);
    const double pitch_rate = -0.8 * drive.slope * std::sin(0.8 * t);
    const double g = kStandardGravity;
    // To first order in roll and pitch.
    const Vector3d force(-g * pitch + 0.45 * std::cos(1.5 * t), g * roll + turning * speed(t), g);
    const Vector3d rate(roll_rate - turning * pitch, pitch_rate + turning * roll, turning);
    samples.push_back(
        {from_seconds(t), force + drive.vibration * Vector3d(n(), n(), n()), rate + drive.bias});
  }
  WheelSpeeds wheel;
  for (int k = 0; k < 20; ++k) {
    const double t = (k + 0.5) * WheelSpeeds::kPart;
    const bool slips = t > 1.5 && t < 2.5;
    wheel.mps.push_back(speed(t) * (slips ? 1 + drive.slip : 1.0) + 0.005 * n());
  }
  return gyro_bias_size(samples, wheel);
}

// The biases of a car's gyro on record (rad/s), and of one that is far better.
const Vector3d kCheap(-0.016, 0.0157, 0.006), kGood(-3e-4, 2e-4, 1e-4);

TEST(GyroBiasSize, IsThatOfTheTwoAxesThatGravityShows) {
  for (unsigned seed = 0; seed < 20; ++seed)
    for (const double slope : {0.0, 0.05})
      for (const double vibration : {0.0, 0.5}) {
        const double cheap = size_of({kCheap, vibration, slope, 0.0}, seed).sigma;
        EXPECT_GT(cheap, 0.006) << slope << " " << vibration;
        EXPECT_LT(cheap, 0.016) << slope << " " << vibration;
        const double good = size_of({kGood, vibration, slope, 0.0}, seed).sigma;
        EXPECT_NEAR(good, kUsualGyroBias, 5e-4) << slope << " " << vibration;
      }
}

TEST(GyroBiasSize, IsNotMadeByASlip) {
  for (unsigned seed = 0; seed < 20; ++seed)
    EXPECT_LT(size_of({kGood, 0.1, 0.02, 0.5}, seed).sigma, 0.005);
}

TEST(GyroBiasSize, IsNotKnownUnderStrongVibration) {
  EXPECT_TRUE(size_of({kCheap, 0.1, 0.02, 0.0}, 1).known);
  EXPECT_FALSE(size_of({kCheap, 10.0, 0.02, 0.0}, 1).known);
}

// An accelerometer with a reversed axis shows such a bias in bends and starts.
TEST(GyroBiasSize, IsTheUsualOneWhereNoGyroIsOffBySoMuch) {
  const GyroBiasSize size = size_of({Vector3d(0.0, 0.3, 0.0), 0.1, 0.02, 0.0}, 1);
  EXPECT_EQ(size.sigma, kUsualGyroBias);
  EXPECT_FALSE(size.known);
}

TEST(GyroBiasSize, IsTheUsualOneWhereDataAreMissing) {
  for (const std::size_t parts : {0, 20}) {
    const GyroBiasSize size = gyro_bias_size({}, {0, std::vector<double>(parts, 1.0)});
    EXPECT_EQ(size.sigma, kUsualGyroBias);
    EXPECT_FALSE(size.known);
  }
}

}  // namespace
}  // namespace gprodom
