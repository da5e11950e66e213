// Feeds the estimator a robot that stands for five seconds, by itself and on threads of its own;
// exit code 0 where both say so.
#include <gprodom/live.h>
#include <gprodom/odometry.h>

#include <cmath>
#include <cstdio>

int main() {
  gprodom::Odometry odometry(gprodom::default_config());
  std::size_t live_poses = 0;
  gprodom::Live live(gprodom::default_config(), [&live_poses](const gprodom::Outputs& outputs) {
    live_poses += outputs.odometry.size();
  });
  std::size_t poses = 0;
  double farthest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    gprodom::ImuSample imu;
    imu.time = 1'700'000'000'000'000'000 + i * 5'000'000LL;
    imu.acceleration = {0.002 * std::sin(i), 0.002 * std::cos(i), 9.80665};
    imu.angular_velocity = {4e-4 * std::sin(1.7 * i), 4e-4 * std::cos(2.3 * i), 0.0};
    odometry.add(imu);
    odometry.add(gprodom::WheelSample{imu.time, 0.0});
    live.push(imu);
    live.push(gprodom::WheelSample{imu.time, 0.0});
    for (const auto& estimate : odometry.step().odometry) {
      ++poses;
      farthest = std::fmax(farthest, estimate.p_odom_body.norm());
    }
  }
  live.stop();
  std::printf("%zu poses, at most %.4f m from the origin\n", poses, farthest);
  return poses > 500 && live_poses == poses && farthest < 0.01 ? 0 : 1;
}
