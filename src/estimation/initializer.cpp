#include "estimation/initializer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/median.h"
#include "estimation/factors.h"
#include "estimation/kernels/so3.h"

namespace gprodom {

using Eigen::Vector3d;

namespace {

struct Moments {
  Vector3d mean = Vector3d::Zero();
  double deviation = 0.0;  // RMS over the three axes
};

Moments moments(const std::vector<ImuSample>& samples, Vector3d ImuSample::*field) {
  Moments m;
  for (const auto& s : samples) m.mean += s.*field;
  m.mean /= static_cast<double>(samples.size());
  for (const auto& s : samples) m.deviation += (s.*field - m.mean).squaredNorm();
  m.deviation = std::sqrt(m.deviation / (3.0 * static_cast<double>(samples.size() - 1)));
  return m;
}

std::string refuse(const char* format, double value, double limit) {
  char text[240];
  std::snprintf(text, sizeof text, format, value, limit);
  return text;
}

// How far the specific force may be off gravity, of it: at rest by the accelerometer's bias; on the
// move by accelerations and rectified vibration as well; and at most by a scale. Beyond that it is
// another unit (g), or no accelerometer.
constexpr double kOffByBias = 0.05, kOffOnTheMove = 0.1, kOffByScale = 0.5;

double off_gravity(double force) { return std::abs(force - kStandardGravity) / kStandardGravity; }

double scale_by(double force, double off_without_it) {
  const double off = off_gravity(force);
  return off <= off_without_it || off > kOffByScale ? 1.0 : force / kStandardGravity;
}

constexpr size_t kParts = 4;  // of the samples' time

// Standard deviation of the means over the parts, of the worst axis.
double unsteadiness(const std::vector<ImuSample>& samples, Vector3d ImuSample::*field) {
  std::vector<Vector3d> means;
  for (size_t i = 0; i < kParts; ++i) {
    const auto part = [&](size_t k) {
      return samples.begin() + static_cast<long>(k * samples.size() / kParts);
    };
    Vector3d sum = Vector3d::Zero();
    for (auto s = part(i); s != part(i + 1); ++s) sum += (*s).*field;
    means.emplace_back(sum / static_cast<double>(part(i + 1) - part(i)));
  }
  Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
  for (const Vector3d& m : means) mean += m / kParts;
  for (const Vector3d& m : means) square += (m - mean).cwiseAbs2() / (kParts - 1.0);
  return std::sqrt(square.maxCoeff());
}

// Limits for the IMU's means over half a second while the wheel stands. A robot that is pushed or
// rolls exceeds them.
constexpr double kSteadyRate = 0.005, kSteadyForce = 0.05;  // rad/s, m/s^2

// Of the samples of a robot that stands with its engine off. A MEMS IMU shows a tenth of both.
constexpr double kMaxGyroDeviation = 0.02;  // rad/s
constexpr double kMaxAccelDeviation = 0.2;  // m/s^2

// Standard deviations of white noise that parts exceed in one of a thousand standstills.
constexpr double kBeyondChance = 2.5;

// Standard deviation of a mean: that of white noise. If the parts differ more than chance lets
// them, that of the parts.
double sigma_of_mean(double white, double unsteady) {
  const double shown = unsteady / std::sqrt(static_cast<double>(kParts));
  return shown > kBeyondChance * white ? shown : white;
}

std::string reason_against(const Config& config, const std::vector<ImuSample>& samples,
                           const Moments& gyro, const Moments& accel, const WheelAtStart& wheel) {
  const double seconds = to_seconds(samples.back().time - samples.front().time);
  const double limit = 2 * config.wheel.noise_floor + 1e-3 + kRestingWheel * seconds;
  if (wheel.path_m > limit)
    return refuse("the wheel turned %.3f m (limit %.3f): hold the robot still to start",
                  wheel.path_m, limit);
  // Noise at rest is spread evenly over the time. A robot that has just stopped, or sets off, shows
  // more at one end.
  const double over = WheelAtStart::kSpeedOver;
  const double at_begin = std::abs(wheel.begin_mps) * over, at_end = std::abs(wheel.end_mps) * over;
  const double even = std::max(0.0, wheel.path_m - at_begin - at_end) / (seconds / over - 2);
  if (seconds > 3 * over &&
      std::max(at_begin, at_end) > 2 * even + 2 * config.wheel.noise_floor + 1e-3)
    return refuse(
        "the wheel turned %.3f m in half a second (%.3f m on the mean): hold the robot still "
        "to start",
        std::max(at_begin, at_end), even);
  const bool quiet = gyro.deviation <= kMaxGyroDeviation && accel.deviation <= kMaxAccelDeviation;
  const double root_dt = std::sqrt(seconds / static_cast<double>(samples.size() - 1));
  const ImuNoise vibration{gyro.deviation * root_dt, accel.deviation * root_dt};
  const bool steady = steady_means(samples, kSteadyRate, kSteadyForce, vibration);
  if (gyro.deviation > kMaxGyroDeviation && !(wheel.received && steady))
    return refuse("gyro deviation %.4f rad/s (limit %.4f): hold the robot still", gyro.deviation,
                  kMaxGyroDeviation);
  if (!quiet && !(wheel.received && steady))
    return refuse(
        "accelerometer deviation %.3f m/s^2 (limit %.3f): hold the "
        "robot still",
        accel.deviation, kMaxAccelDeviation);
  if (gyro.mean.norm() > kMaxGyroBias)
    return refuse(
        "mean rate %.4f rad/s (limit %.4f): turning, or a gyro out "
        "of calibration",
        gyro.mean.norm(), kMaxGyroBias);
  if (off_gravity(accel.mean.norm()) > kOffByBias)
    return refuse("specific force %.3f m/s^2 is not gravity (%.3f): check the IMU's units",
                  accel.mean.norm(), kStandardGravity);
  return {};
}

// Standard deviations of a first state.
struct FirstSigmas {
  double velocity;  // m/s
  double rate;      // rad/s: of the gyro's bias
  double force;     // m/s^2: of the mean specific force, for tilt and accelerometer bias together
  double bias = kAccelBiasSigma;  // m/s^2: of the accelerometer's
};

// m/s^2, of the bias of an accelerometer that is not calibrated, as one whose scale is wrong: 10
// mg.
constexpr double kUncalibratedBias = 0.1;

// Across gravity a bias looks like a tilt. Its size along gravity tells how well the sensor is
// calibrated: the three axes are draws of one normal distribution.
double bias_sigma(const Vector3d& along_gravity, double accel_scale) {
  if (accel_scale != 1.0) return kUncalibratedBias;
  const double shown = along_gravity.norm();
  return shown > kOutOfCalibration ? shown : kAccelBiasSigma;
}

// Rows in the chart at the first state x; docs/estimation.md, "Start".
MarginalPrior first_prior(const Config& config, const NavState& x, const FirstSigmas& sigmas) {
  const double scale_sigma = std::max(config.wheel.scale_sigma, 1e-7);
  MarginalPrior prior;
  prior.x0 = {x};
  prior.A = Eigen::MatrixXd::Zero(17, kStateDim);
  prior.b = Eigen::VectorXd::Zero(17);
  prior.A(0, row::kTheta + 2) = 1 / kOriginYawSigma;
  prior.A.block<3, 3>(1, row::kP).diagonal().setConstant(1 / kOriginPositionSigma);
  prior.A.block<3, 3>(4, row::kV).diagonal().setConstant(1 / sigmas.velocity);
  prior.A.block<3, 3>(7, row::kBg).diagonal().setConstant(1 / sigmas.rate);
  // The accelerometer's bias has a prior mean of 0; x has the part of it that the norm of gravity
  // shows.
  prior.A.block<3, 3>(10, row::kBa).diagonal().setConstant(1 / sigmas.bias);
  prior.b.segment<3>(10) = x.accel_bias / sigmas.bias;
  // Mean specific force = R^T up + bias: it measures only the sum of tilt and bias.
  const Eigen::Matrix3d RT = x.R_odom_body().transpose();
  const Vector3d up(0, 0, kStandardGravity);
  Eigen::Matrix<double, 3, kStateDim> force = Eigen::Matrix<double, 3, kStateDim>::Zero();
  force.block<3, 3>(0, row::kTheta) = RT * so3::skew(up);
  force.block<3, 3>(0, row::kBa).setIdentity();
  prior.A.block<3, kStateDim>(13, 0) = force / sigmas.force;
  prior.A(16, row::kScale) = 1 / scale_sigma;
  return prior;
}

// Roll, pitch and accelerometer bias of a mean specific force at rest (body); the rest is zero.
NavState level_state(const Config& config, TimeNs time, const Vector3d& force) {
  NavState x;
  x.time = time;
  const Vector3d up_body = force.normalized();
  const double roll = std::atan2(up_body.y(), up_body.z());
  const double pitch = std::atan2(-up_body.x(), std::hypot(up_body.y(), up_body.z()));
  x.q_odom_body =
      Eigen::AngleAxisd(pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Vector3d::UnitX());
  x.accel_bias = force - up_body * kStandardGravity;
  x.wheel_scale = config.wheel.scale;
  return x;
}

std::vector<ImuSample> divided(std::vector<ImuSample> samples, double accel_scale) {
  for (ImuSample& s : samples) s.acceleration /= accel_scale;
  return samples;
}

std::string too_few(const std::vector<ImuSample>& samples, double needed_s) {
  if (samples.size() < 10)
    return refuse("%.0f IMU samples in %.1f s: waiting for IMU data",
                  static_cast<double>(samples.size()), needed_s);
  const double duration = to_seconds(samples.back().time - samples.front().time);
  if (duration < 0.9 * needed_s)
    return refuse("%.2f s of standstill seen (initializer.duration %.2f)", duration, needed_s);
  return {};
}

// Standard deviations for a start on the move.
constexpr double kLeastForce = 0.2;  // m/s^2; a slope of 0.02 rad
constexpr double kLeastSpeed = 0.1;  // m/s
constexpr double kSpeedShare = 0.1;  // of the speed: the wheel's scale, slip, side slip
// The same if the wheel agrees with the accelerations: what is left is the gyro's bias, which tilts
// gravity, and the wheel's scale.
constexpr double kForceIfAgreed = 0.05, kSpeedIfAgreed = 0.03, kShareIfAgreed = 0.05;

// Mean over each part of the speed that the accelerations give, up to a constant and a slope.
std::vector<double> speeds_by_imu(const std::vector<ImuSample>& samples, TimeNs from,
                                  std::size_t parts) {
  std::vector<double> sums(parts), counts(parts);
  double speed = 0.0, pitch = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double dt = to_seconds(samples[i].time - samples[i - 1].time);
    const ImuSample& s = samples[i];
    pitch += s.angular_velocity.y() * dt;
    speed += (s.acceleration.x() + kStandardGravity * std::sin(pitch)) * dt;
    const double part = to_seconds(s.time - from) / WheelSpeeds::kPart;
    if (part < 0 || part >= static_cast<double>(parts)) continue;
    sums[static_cast<std::size_t>(part)] += speed;
    counts[static_cast<std::size_t>(part)] += 1;
  }
  for (std::size_t k = 0; k < parts; ++k) sums[k] /= counts[k];  // NaN without a sample
  return sums;
}

}  // namespace

bool steady_means(const std::vector<ImuSample>& samples, double most_rate, double most_force,
                  const ImuNoise& vibration) {
  const double part_s = to_seconds(samples.back().time - samples.front().time) / kParts;
  const double chance = kBeyondChance / std::sqrt(part_s);
  return unsteadiness(samples, &ImuSample::angular_velocity) <
             std::hypot(most_rate, chance * vibration.gyro_density) &&
         unsteadiness(samples, &ImuSample::acceleration) <
             std::hypot(most_force, chance * vibration.accel_density);
}

bool speeds_agree(const std::vector<ImuSample>& samples, const WheelSpeeds& wheel) {
  constexpr std::size_t kFewest = 10;  // parts
  constexpr std::size_t kOver = 2;     // parts; over which a slip begins
  // A jump beyond the noise of the other parts (standard deviations), and beyond what tilt in a
  // bend and the wheel's own noise make: m/s, and of the speed.
  constexpr double kBeyondNoise = 5.0, kLeastJump = 0.05, kJumpShare = 0.1;
  constexpr double kNormal = 1.483;  // standard deviation over median deviation
  if (wheel.mps.size() < kFewest) return false;
  const std::vector<double> by_imu = speeds_by_imu(samples, wheel.from, wheel.mps.size());
  std::vector<double> jumps, deviations;
  double fastest = 0.0;
  for (std::size_t k = 0; k < wheel.mps.size(); ++k) {
    fastest = std::max(fastest, std::abs(wheel.mps[k]));
    if (k < kOver) continue;
    jumps.push_back(wheel.mps[k] - wheel.mps[k - kOver] - by_imu[k] + by_imu[k - kOver]);
    if (!std::isfinite(jumps.back())) return false;
  }
  const double slope = median(jumps);
  for (const double jump : jumps) deviations.push_back(std::abs(jump - slope));
  const double noise = kNormal * median(deviations);
  const double largest = *std::max_element(deviations.begin(), deviations.end());
  return largest < std::max(kBeyondNoise * noise, kLeastJump + kJumpShare * fastest);
}

Initialization initialize(const Config& config, const std::vector<ImuSample>& measured,
                          const WheelAtStart& wheel, double share) {
  if (std::string why = too_few(measured, share * config.initializer.duration); !why.empty())
    return {std::nullopt, why};
  const double accel_scale =
      accel_scale_at_rest(moments(measured, &ImuSample::acceleration).mean.norm());
  const std::vector<ImuSample> samples = divided(measured, accel_scale);
  const Moments accel = moments(samples, &ImuSample::acceleration);
  const Moments gyro = moments(samples, &ImuSample::angular_velocity);
  if (std::string why = reason_against(config, samples, gyro, accel, wheel); !why.empty())
    return {std::nullopt, why};

  InitialState initial;
  const double duration = to_seconds(samples.back().time - samples.front().time);
  const double root_dt = std::sqrt(duration / static_cast<double>(samples.size() - 1));
  initial.noise.gyro_density = std::max(config.imu.gyro_noise_density, gyro.deviation * root_dt);
  initial.noise.accel_density = std::max(config.imu.accel_noise_density, accel.deviation * root_dt);
  initial.state = level_state(config, samples.back().time, accel.mean);
  initial.state.gyro_bias = gyro.mean;
  initial.accel_scale = accel_scale;
  const double root = std::sqrt(duration);
  initial.prior = first_prior(
      config, initial.state,
      {std::max({StandstillSigmas().velocity, wheel.path_m / duration, std::abs(wheel.end_mps)}),
       sigma_of_mean(initial.noise.gyro_density / root,
                     unsteadiness(samples, &ImuSample::angular_velocity)),
       sigma_of_mean(initial.noise.accel_density / root,
                     unsteadiness(samples, &ImuSample::acceleration)),
       bias_sigma(initial.state.accel_bias, accel_scale)});
  return {initial, {}};
}

double accel_scale_at_rest(double force) { return scale_by(force, kOffByBias); }

double accel_scale_on_the_move(const std::vector<ImuSample>& samples) {
  if (samples.empty()) return 1.0;
  return scale_by(moments(samples, &ImuSample::acceleration).mean.norm(), kOffOnTheMove);
}

Initialization initialize_moving(const Config& config, const std::vector<ImuSample>& measured,
                                 const WheelAtStart& wheel, const ImuBias& bias, double accel_scale,
                                 bool has_begun) {
  if (config.initializer.wait_for_standstill)
    return {std::nullopt, "initializer.wait_for_standstill: hold the robot still to start"};
  if (std::string why = too_few(measured, config.initializer.duration); !why.empty())
    return {std::nullopt, why};
  const std::vector<ImuSample> samples = divided(measured, accel_scale);
  if (!wheel.received) return {std::nullopt, "no wheel: hold the robot still to start"};
  const Moments gyro = moments(samples, &ImuSample::angular_velocity);
  const Moments accel = moments(samples, &ImuSample::acceleration);
  const double duration = to_seconds(samples.back().time - samples.front().time);
  const double scale = config.wheel.scale;
  const double sign = wheel.begin_mps + wheel.end_mps < 0 ? -1.0 : 1.0;
  const double speed = sign * wheel.path_m / scale / duration;
  const double over = WheelAtStart::kSpeedOver;
  const double acceleration = (wheel.end_mps - wheel.begin_mps) / scale / (duration - over);
  const Vector3d force =
      accel.mean - Vector3d(acceleration, 0, 0) - gyro.mean.cross(Vector3d(speed, 0, 0));
  if (!has_begun && off_gravity(force.norm()) > kOffOnTheMove)
    return {std::nullopt, refuse("specific force %.3f m/s^2 is not gravity (%.3f): check the IMU",
                                 force.norm(), kStandardGravity)};
  InitialState initial;
  initial.on_the_move = true;
  initial.accel_scale = accel_scale;
  initial.noise = {config.imu.gyro_noise_density, config.imu.accel_noise_density};
  initial.state = level_state(config, samples.back().time, force);
  initial.state.accel_bias = bias.accel;  // driving changes the size of the mean force
  initial.state.gyro_bias = bias.gyro;
  // The wheel's speed is that of the middle of its time; the accelerations carry it on.
  double gained = 0;
  std::size_t count = 0;
  for (auto i = samples.rbegin(); i != samples.rend(); ++i, ++count) {
    if (samples.back().time - i->time > from_seconds(over)) break;
    gained += i->acceleration.x() - force.x();
  }
  const double end_speed = wheel.end_mps / scale + 0.5 * over * gained / static_cast<double>(count);
  initial.state.v_odom = initial.state.q_odom_body * Vector3d(end_speed, 0, 0);
  const double spread = unsteadiness(samples, &ImuSample::acceleration);
  const double least_speed = wheel.agrees ? kSpeedIfAgreed : kLeastSpeed;
  const double share = wheel.agrees ? kShareIfAgreed : kSpeedShare;
  initial.prior = first_prior(config, initial.state,
                              {least_speed + share * std::abs(wheel.end_mps), bias.gyro_sigma,
                               std::max(wheel.agrees ? kForceIfAgreed : kLeastForce, spread),
                               bias_sigma(initial.state.accel_bias, accel_scale)});
  return {initial, {}};
}

}  // namespace gprodom
