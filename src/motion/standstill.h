// Does the robot stand? From IMU, wheel and what the radar said.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/sensor_history.h"

namespace gprodom {

struct StandstillVerdict {
  struct Rate {
    Eigen::Vector3d mean;  // rad/s, body
    double sigma;          // per axis
  };

  bool standing = false;
  bool wheel_contradicted = false;  // it stands although the wheel turns
  // Of the gyro, where all else says standstill: more than its bias accounts for.
  std::optional<Rate> steady_rate;
};

// What is known of this robot at rest, and of the gyro.
struct AtRest {
  ImuNoise noise;
  double wheel_mps = 0.0;  // unsigned, that the wheel shows nevertheless
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  double bias_sigma = 0.0;  // rad/s, per axis
  double unseen_mps = 0.0;  // motion slower than that may pass the radar unseen
};

// Over [from, to], the interval between two states.
//  - The IMU is still: noise within imu_ratio of the reference, no turning beyond it.
//  - Either the wheel stands as well, or the radar saw standing ground over the whole interval and
//    the wheel, if it is heard, does not turn so slowly that this could have passed unseen.
// The wheel alone proves nothing.
StandstillVerdict judge_standstill(const Config& config, const AtRest& at_rest,
                                   const ImuHistory& imu, const WheelHistory& wheel,
                                   const std::vector<gpr::Standstill>& radar_standing, TimeNs from,
                                   TimeNs to);

// A gyro bias that has moved by more than its walk is seen at the next standstill, where a steady
// rate is the bias. Until then the heading went off unseen.
class BiasWatch {
 public:
  // Of each state interval in turn. The bias (rad/s, body), once all but a steady rate said
  // standstill for long enough.
  std::optional<Eigen::Vector3d> moved(const StandstillVerdict& verdict, double dt_s);

 private:
  static constexpr double kPatience_s = 1.0;

  double still_s_ = 0.0;                              // so far
  Eigen::Vector3d turned_ = Eigen::Vector3d::Zero();  // in it, rad
};

}  // namespace gprodom
