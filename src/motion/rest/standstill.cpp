#include "motion/rest/standstill.h"

#include <algorithm>
#include <cmath>

#include "estimation/initializer.h"
#include "motion/rest/imu_noise.h"

namespace gprodom {

using Eigen::Vector3d;

namespace {

// IMU variance over that at rest, from which the robot no longer stands. Over a state's interval
// the variance of white noise scatters by less (13 % at 200 Hz), and a drive shows several times
// it.
constexpr double kRestVarianceRatio = 1.6;

// rad/s. Shocks and heat move the bias of cheap gyros by 2 deg/s. A robot that turns on the spot is
// faster than 3 deg/s, or less steady.
constexpr double kLargestBiasStep = 0.05;

// Samples; of fewer the variance scatters by more than it rises on a drive. What an IMU of 50 Hz
// has between two states.
constexpr std::size_t kShowNoise = 10;

constexpr double kRestSpread = 1.5;  // times the wheel's path at rest

// Limits for the means over quarters of a second. A body that still rocks after a stop turns by
// several times this rate.
constexpr double kSteadyRate = 1e-3, kSteadyForce = 0.05;  // rad/s, m/s^2

// m/s; a robot that brakes is slower than this by the estimate when its wheel has stood for a
// second.
constexpr double kSlow = 0.2;

struct Stillness {
  bool quiet = false;                // no vibration
  Vector3d rate = Vector3d::Zero();  // mean
  Vector3d rate_less_bias = Vector3d::Zero();
  double rate_sigma = 0.0;  // per axis, of noise and bias

  // The mean rate of a robot that stands is within a few deviations of its noise.
  bool turns() const { return rate_less_bias.norm() > 6 * rate_sigma; }
};

// noisy: the samples that show the vibration; those that show the rate may be fewer.
Stillness stillness(const AtRest& at_rest, const std::vector<ImuSample>& samples,
                    const std::vector<ImuSample>& noisy) {
  if (samples.size() < 2 || noisy.size() < 4) return {};
  Stillness s;
  const ImuNoise noise = measured_noise(noisy);
  const ImuNoise& reference = at_rest.noise;
  const double ratio = std::sqrt(kRestVarianceRatio);
  s.quiet = noise.accel_density < ratio * reference.accel_density &&
            noise.gyro_density < ratio * reference.gyro_density;
  for (const auto& sample : samples) s.rate += sample.angular_velocity;
  s.rate /= static_cast<double>(samples.size());
  s.rate_less_bias = s.rate - at_rest.gyro_bias;
  const double seconds = to_seconds(samples.back().time - samples.front().time);
  s.rate_sigma = std::hypot(reference.gyro_density / std::sqrt(seconds), at_rest.bias_sigma);
  return s;
}

// Over [from, to]. The vibration is that of enough samples, of a slow IMU from before as well.
Stillness stillness(const AtRest& at_rest, const ImuHistory& imu, TimeNs from, TimeNs to) {
  const auto samples = imu.between(from, to);
  return stillness(at_rest, samples,
                   samples.size() < kShowNoise ? imu.last(kShowNoise, to) : samples);
}

// The wheel's motion at rest: by another amount at each standstill, but spread evenly over the
// time.
bool within_noise(const WheelConfig& config, const AtRest& at_rest, const LastSecond& last) {
  constexpr double kUneven = 0.5;  // share of the mean speed
  constexpr double kAll_s = LastSecond::kBefore + LastSecond::kAfter;
  const double floor_m = 2 * config.noise_floor;
  const bool moves_at_rest = !at_rest.known || at_rest.wheel_mps > floor_m;  // over a second
  const double resting_mps = moves_at_rest ? kRestingWheel : 0.0;
  const double even_m = last.rolled_m * LastSecond::kLately / kAll_s;
  return last.rolled_m <= floor_m + resting_mps * kAll_s &&
         std::abs(last.rolled_lately_m - even_m) <= floor_m + kUneven * even_m;
}

}  // namespace

StandstillVerdict judge_standstill(const Config& config, const AtRest& at_rest,
                                   const ImuHistory& imu, const WheelHistory& wheel,
                                   const std::vector<gpr::Standstill>& radar_standing, TimeNs from,
                                   TimeNs to) {
  if (!config.standstill.enabled) return {};
  const Stillness now = stillness(at_rest, imu, from, to);
  if (!now.quiet) return {};
  const TimeNs margin = std::max<TimeNs>(0, (from_seconds(kStillFor_s) - (to - from)) / 2);
  const bool has_wheel = config.wheel.enabled && wheel.distance(to);
  const TimeNs since = std::min(from - margin, to - at_rest.wheel_tick);
  const double rolled_m = wheel.path(since, to + margin);
  const double seconds = to_seconds(to + margin - since);
  const bool wheel_still =
      has_wheel && !at_rest.wheel_hides &&
      rolled_m <= 2 * config.wheel.noise_floor + kRestSpread * at_rest.wheel_mps * seconds;
  const bool below_sight = has_wheel && !wheel_still && rolled_m <= at_rest.unseen_mps * seconds;
  const bool radar_still = !below_sight && std::any_of(radar_standing.begin(), radar_standing.end(),
                                                       [&](const gpr::Standstill& s) {
                                                         return s.from <= from && s.to >= to;
                                                       });
  const Stillness longer = stillness(at_rest, imu, from - margin, to + margin);
  StandstillVerdict verdict;
  if (now.turns()) {
    if (wheel_still && (radar_still || !at_rest.radar_heard) && longer.quiet)
      verdict.steady_rate = {now.rate, now.rate_sigma};
    return verdict;
  }
  // Without the radar the IMU must be still for longer: in a smooth glide it is still for moments.
  verdict.standing = radar_still || (wheel_still && longer.quiet && !longer.turns());
  verdict.wheel_contradicted = radar_still && !wheel_still;
  return verdict;
}

bool is_steady(const std::vector<ImuSample>& samples, const ImuNoise& vibration) {
  return steady_means(samples, kSteadyRate, kSteadyForce, vibration);
}

bool stands_for_a_second(const WheelConfig& config, const AtRest& at_rest,
                         const Vibration& vibration, const LastSecond& last) {
  if (last.imu.size() < kEnoughForNoise || last.estimated_mps > kSlow) return false;
  if (!within_noise(config, at_rest, last)) return false;
  AtRest shaken = at_rest;
  shaken.noise = measured_noise(last.imu);
  std::optional<ImuNoise> known;
  if (at_rest.known) known = at_rest.noise;
  return vibration.hides_rest(shaken.noise, known) && is_steady(last.imu, shaken.noise) &&
         !stillness(shaken, last.imu, last.imu).turns();
}

std::optional<Vector3d> BiasWatch::new_bias(const StandstillVerdict& verdict, const Vector3d& bias,
                                            double dt_s) {
  if (!verdict.steady_rate) {
    *this = {};
    return std::nullopt;
  }
  const auto& [rate, sigma] = *verdict.steady_rate;
  if (still_s_ > 0 && (rate - turned_ / still_s_).norm() > 6 * std::sqrt(2.0) * sigma) {
    still_s_ = 0.0;
    turned_.setZero();
  }
  still_s_ += dt_s;
  turned_ += rate * dt_s;
  if (still_s_ < kPatience_s) return std::nullopt;
  const Vector3d found = turned_ / still_s_;
  *this = {};
  turns_at_rest_ = (found - bias).norm() > kLargestBiasStep;
  if (turns_at_rest_) return std::nullopt;
  return found;
}

}  // namespace gprodom
