// An encoder of some centimetres a tick, as a few magnets on a wheel give it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gprodom/odometry.h"
#include "pipeline/test_drive.h"
#include "support/noise.h"

namespace gprodom {
namespace {

// Goes 1.4 m in 4 s and stands for 2 s, again and again. The greatest error of the position, m.
double worst_error(unsigned seed, double tick_m, double resolution_m) {
  constexpr double kStands = 3.0, kGoes = 4.0, kRound = 6.0, kSpeed = 0.7;  // s, m/s
  Config config = default_config();
  config.gpr.enabled = false;
  Odometry odometry(config);
  Noise noise(seed);
  const auto speed_at = [&](double t) {
    const double in_round = t < kStands ? kRound : std::fmod(t - kStands, kRound);
    const double middle = 0.5 * kGoes;
    return kSpeed * std::max(0.0, 1.0 - std::abs(in_round - middle) / middle);
  };
  double position = 0.0, worst = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i, speed = speed_at(t), next_speed = speed_at(t + 0.01);
    ImuSample imu;
    imu.time = kDriveStart + i * kImuPeriod;
    imu.acceleration =
        Eigen::Vector3d((next_speed - speed) / 0.01, 0.0, 9.80665) + noise.vector(0.05);
    imu.angular_velocity = noise.vector(0.002);
    odometry.add(imu);
    if (i % 5 == 0)
      odometry.add(WheelSample{imu.time, tick_m * std::floor(position / tick_m), resolution_m});
    for (const OdometryEstimate& estimate : odometry.step().odometry)
      if (estimate.time == imu.time)
        worst = std::max(worst, std::abs(estimate.p_odom_body.x() - position));
    position += 0.005 * (speed + next_speed);
  }
  return worst;
}

TEST(CoarseEncoder, ItsTicksAreNeitherSlipNorStandstill) {
  for (const double tick_m : {0.02, 0.05}) {
    double with = 0.0, without = 0.0;
    for (const unsigned seed : {1, 2}) {
      with = std::max(with, worst_error(seed, tick_m, tick_m));
      without = std::max(without, worst_error(seed, tick_m, 0.0));
    }
    EXPECT_LT(with, 0.05 + 4 * tick_m);
    EXPECT_GT(without, 4 * with) << "the resolution need not be known";
  }
}

}  // namespace
}  // namespace gprodom
