// The first state and its prior: gravity, gyro bias and noise from a standstill, or from driving.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

struct Initialization {
  std::optional<InitialState> initial;
  std::string refusal;  // reason why there is no initial state, for the operator
};

// The wheel's data over the time of the IMU samples.
struct WheelAtStart {
  bool received = false;                     // the wheel has sent data in this time
  double path_m = 0.0;                       // unsigned
  double begin_mps = 0.0, end_mps = 0.0;     // signed, means over the first and the last
  static constexpr double kSpeedOver = 0.5;  // s
  bool agrees = false;  // with the accelerations of some seconds: it rolls without slip
};

// Signed mean speeds of the wheel over parts in a row, from a time on.
struct WheelSpeeds {
  TimeNs from = 0;
  std::vector<double> mps;
  static constexpr double kPart = 0.2;  // s
};

// Does the wheel's speed change as the accelerations say? Tilt and bias are not known, so what is
// looked for are the jumps with which a slip begins and ends. samples: of the same time.
bool speeds_agree(const std::vector<ImuSample>& samples, const WheelSpeeds& wheel);

// Apparent speed at rest of a wheel whose signal has no sign, so that its noise is rectified (0.011
// for a gyro on a wheel).
inline constexpr double kRestingWheel = 0.02;  // m/s

// Do the means of gyro and accelerometer over the quarters of the time agree, within most_rate
// (rad/s) and most_force (m/s^2)? A robot that is pushed, or rolls, moves them; an engine does not,
// beyond what white noise of its size does.
bool steady_means(const std::vector<ImuSample>& samples, double most_rate, double most_force,
                  const ImuNoise& vibration);

// From a standstill. samples: IMU in body axes, in time order, the last initializer.duration
// seconds. If the wheel shows only noise and the means of the IMU are steady, the robot stands,
// even if its engine shakes it. Without a wheel the IMU must be quiet. The state stands at the last
// sample: position 0, yaw 0, roll and pitch from gravity.
// share: of initializer.duration that the samples must cover.
// A force that is not gravity, but near it, shows the accelerometer's scale.
Initialization initialize(const Config& config, const std::vector<ImuSample>& samples,
                          const WheelAtStart& wheel, double share = 1.0);

// What an uncalibrated gyro may be off by.
inline constexpr double kMaxGyroBias = 0.05;  // rad/s

// Standard deviation of the bias of an uncalibrated MEMS gyro of good quality.
inline constexpr double kUsualGyroBias = 0.002;  // rad/s

// The accelerometer's scale by the norm of its mean specific force at rest (m/s^2): 1 if a bias
// explains that, or if it is too far from gravity to be a scale.
double accel_scale_at_rest(double force);

// The same by the mean over some time of driving, which is off gravity by more than at rest.
double accel_scale_on_the_move(const std::vector<ImuSample>& samples);

// A gyro's bias, rad/s, with the standard deviation of an axis, and an accelerometer's along
// gravity (body, m/s^2), which tells the size of the others.
struct ImuBias {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  double gyro_sigma = kUsualGyroBias;
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();
};

// On the move, from the same kind of samples: tilt from the mean force less the part that wheel and
// gyro explain; speed from the wheel. The solutions of the first seconds improve this state. It is
// surer if the wheel agrees with the accelerations. accel_scale: of the samples' forces.
// has_begun: an estimate of these samples began here before, so this one does not refuse a mean
// force that is off gravity.
Initialization initialize_moving(const Config& config, const std::vector<ImuSample>& samples,
                                 const WheelAtStart& wheel, const ImuBias& bias = {},
                                 double accel_scale = 1.0, bool has_begun = false);

}  // namespace gprodom
