// A robot on a straight line, with a SlipWatch that hears its wheel, its radar and its estimates.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "gprodom/config.h"
#include "motion/history/sensor_history.h"
#include "motion/slip_watch.h"

namespace gprodom {

// Estimates at 200 Hz, the wheel at 50 Hz, the radar once a second; what they say is set by the
// test.
class WatchedDrive {
 public:
  static constexpr double kSpeed = 0.4;  // m/s, of the robot

  double ground = kSpeed, wheel_speed = kSpeed;  // m/s
  double published = kSpeed, sigma = 0.01;       // m/s
  double scale = 1.0;                            // of the wheel
  bool wheel_speaks = true, radar_speaks = true, asked = true;
  bool speed_known = true;
  SlipWatch watch{WheelConfig(), SmootherConfig().lag};
  std::optional<SpeedCorrection> correction;

  // No radar, and nobody asks for a speed.
  static WatchedDrive alone() {
    WatchedDrive drive;
    drive.radar_speaks = drive.asked = false;
    return drive;
  }

  void run(double seconds) {
    for (int n = 0; n < seconds * 200 - 0.5; ++n, ++i_) {
      const TimeNs now = from_seconds(100 + 0.005 * i_);
      wheel_m_ += 0.005 * wheel_speed * scale;
      if (wheel_speaks && i_ % 4 == 0) wheel_.insert({wheel_now_ = now, wheel_m_});
      OdometryEstimate estimate;
      estimate.time = now;
      estimate.v_body.x() = published;
      estimate.velocity_covariance = sigma * sigma * Eigen::Matrix3d::Identity();
      estimate.wheel_scale = scale;
      watch.add(estimate, wheel_, wheel_now_, speed_known);
      if (!correction && asked && i_ % 40 == 0)
        correction = watch.take_speed_correction(now - 50'000'000, wheel_, scale);
      if (!radar_speaks || i_ % 200 != 199) continue;
      Displacement radar;
      radar.to = now - 50'000'000;
      radar.from = radar.to - 1'100'000'000;
      radar.distance_m = 1.1 * std::abs(ground);
      radar.sigma_m = 0.2 * radar.distance_m;
      watch.compare_with_radar(radar, wheel_, scale);
    }
  }
  bool contradicted() const { return watch.between(wheel_now_ - 100'000'000, wheel_now_); }
  // Of a time since the beginning, s.
  bool slipped(double from, double to) const {
    return watch.between(from_seconds(100 + from), from_seconds(100 + to));
  }

 private:
  WheelHistory wheel_{5.0};
  double wheel_m_ = 0.0;
  TimeNs wheel_now_ = 0;
  int i_ = 0;
};

}  // namespace gprodom
