// Does the robot stand? Decided from IMU, wheel and radar.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/history/sensor_history.h"
#include "motion/rest/vibration.h"

namespace gprodom {

struct StandstillVerdict {
  struct Rate {
    Eigen::Vector3d mean;  // rad/s, body
    double sigma;          // per axis
  };

  bool standing = false;
  bool wheel_contradicted = false;  // the robot stands although the wheel turns
  // Mean rate of the gyro, if it differs from the bias although all other sensors show a
  // standstill. Those are the wheel and, if it is heard, the radar.
  std::optional<Rate> steady_rate;
};

// What is known about this robot's sensors at rest.
struct AtRest {
  ImuNoise noise;
  double wheel_mps = 0.0;  // unsigned speed that the wheel shows at rest
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  double bias_sigma = 0.0;   // rad/s, per axis
  double unseen_mps = 0.0;   // the radar may miss motion slower than this
  bool known = true;         // noise and wheel_mps were measured at a standstill
  bool radar_heard = true;   // of late
  TimeNs wheel_tick = 0;     // WheelTick::longest()
  bool wheel_hides = false;  // WheelTick::hides_motion(): its standing shows nothing
};

// s. IMU and wheel must be still for so long: a robot that glides evenly is, for moments.
inline constexpr double kStillFor_s = 0.4;

// Over [from, to], the interval between two states. The robot stands if both hold:
//  - The IMU is still: its noise is about that at rest, and no rate beyond that noise.
//  - Either the wheel stands, or the radar saw a standstill over the whole interval. The radar does
//    not count if the wheel turns more slowly than the radar can detect.
// A standing wheel alone is not enough.
StandstillVerdict judge_standstill(const Config& config, const AtRest& at_rest,
                                   const ImuHistory& imu, const WheelHistory& wheel,
                                   const std::vector<gpr::Standstill>& radar_standing, TimeNs from,
                                   TimeNs to);

// The time around the end of a state's interval.
struct LastSecond {
  static constexpr double kBefore = 1.0, kAfter = 0.2;  // s; the robot does not drive off either
  static constexpr double kLately = 0.4;                // s, at the end of that
  std::vector<ImuSample> imu;
  double rolled_m = 0.0;         // unsigned path of the wheel, or of either side of a pair
  double rolled_lately_m = 0.0;  // over kLately
  double estimated_mps = 0.0;    // speed of the newest state
};

// Whether the means over quarters of the samples' time are as steady as those of a robot that
// stands.
bool is_steady(const std::vector<ImuSample>& samples, const ImuNoise& vibration);

// A standstill that the IMU's vibration hides, as with an engine that runs: the wheel is within its
// own noise for a second, and the means of the IMU are steady. The estimated speed must be low as
// well, or a wheel that is stuck would stop a robot that drives.
bool stands_for_a_second(const WheelConfig& config, const AtRest& at_rest,
                         const Vibration& vibration, const LastSecond& last);

// Detects a gyro bias that has changed by more than its random walk: at the next standstill, the
// steady rate is the new bias. Until then the error of the heading cannot be noticed. A larger rate
// may also be that of a robot which is turned on the spot, and is only told.
class BiasWatch {
 public:
  // Call for each state interval in turn. Returns the new bias (rad/s, body) once the rate was
  // steady for long enough while all else showed a standstill.
  std::optional<Eigen::Vector3d> new_bias(const StandstillVerdict& verdict,
                                          const Eigen::Vector3d& bias, double dt_s);

  // The rate is steady, and too large for a step of the bias.
  bool turns_at_rest() const { return turns_at_rest_; }

 private:
  static constexpr double kPatience_s = 1.0;

  bool turns_at_rest_ = false;
  double still_s_ = 0.0;                              // duration of the steady rate so far
  Eigen::Vector3d turned_ = Eigen::Vector3d::Zero();  // its integral, rad
};

}  // namespace gprodom
