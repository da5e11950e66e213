#include "motion/turn_rate.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom {

namespace {

// Before a drive has shown anything, as of a robot indoors: standard deviation (rad/s), time of
// correlation, and the intervals that this counts for (ten seconds).
constexpr double kRate = 0.35, kCorrelation_s = 2.0, kCount = 50.0;
// s. Below the first an interval is not short; beyond the second a robot only waits or turns for
// ever, and the gap's ends would be extrapolated too far.
constexpr double kShortestMemory_s = 0.3, kLongestMemory_s = 10.0;
constexpr TimeNs kLag = 1'000'000'000, kJitter = 100'000'000;

// Share of a gap's variance that its first part has, by the part's length over the gap's: the turn
// is known at both ends, so it grows in the middle.
double share(double part) {
  const double u = std::clamp(part, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

// How sure it is that the robot moves in an interval: the share of its wheel's distance that is no
// noise of a wheel at rest (Wiener's). 1 where no wheel tells.
double moving(const StateInput& input, double resting_m) {
  double rolled_m = 0.0;
  for (const MotionStep& step : input.steps) rolled_m += step.wheel_m;
  const double square = rolled_m * rolled_m, noise = resting_m * resting_m;
  return input.has_wheel && square + noise > 0 ? square / (square + noise) : 1.0;
}

}  // namespace

TurnRate::TurnRate()
    : square_(kCount * kRate * kRate),
      product_(square_ * std::exp(-to_seconds(kLag) / kCorrelation_s)),
      count_(kCount) {}

void TurnRate::complete(StateInput& input, TimeNs from, const Eigen::Vector3d& gyro_bias,
                        const ImuHistory& imu, double resting_m) {
  if (!imu_silent(input.steps)) {
    double turned = 0.0;
    for (const MotionStep& step : input.steps)
      turned += (step.angular_velocity - gyro_bias).z() * step.dt;
    learn(turned / to_seconds(input.time - from), input.time);
    return;
  }
  const double moves = moving(input, resting_m);
  double at_s = 0.0;
  for (MotionStep& step : input.steps) {
    const double begin_s = std::exchange(at_s, at_s + step.dt);
    const auto ends = imu.around(from + from_seconds(begin_s + 0.5 * step.dt));
    if (!step.long_gap || !ends) continue;
    const double gap_s = to_seconds(ends->second.time - ends->first.time);
    const double since = to_seconds(from - ends->first.time) + begin_s;
    step.gap_turn = turn(gap_s,
                         {(ends->first.angular_velocity - gyro_bias).z(),
                          (ends->second.angular_velocity - gyro_bias).z()},
                         since, since + step.dt, moves);
    input.turn_variance +=
        variance(gap_s) * (share((since + step.dt) / gap_s) - share(since / gap_s));
  }
}

void TurnRate::learn(double rate, TimeNs to) {
  while (!recent_.empty() && recent_.front().to < to - kLag) recent_.pop_front();
  if (!recent_.empty() && recent_.front().to < to - kLag + kJitter) {
    const double earlier = recent_.front().rate;
    product_ += rate * earlier;
    square_ += 0.5 * (rate * rate + earlier * earlier);
    sum_ += 0.5 * (rate + earlier);
    count_ += 1;
    seconds_ += to_seconds(to - recent_.back().to);
  }
  recent_.push_back({to, rate});
}

TurnRate::Process TurnRate::about(double mean) const {
  const double shown = count_ - kCount;
  const double added = shown * mean * mean - 2 * mean * sum_;
  const double square = square_ + added, product = product_ + added, lag_s = to_seconds(kLag);
  const double correlation = std::clamp(product / square, std::exp(-lag_s / kShortestMemory_s),
                                        std::exp(-lag_s / kLongestMemory_s));
  return {mean, 0.0, square / count_, -lag_s / std::log(correlation)};
}

// The mean of the process over a time T has the variance 2 sigma^2 tau / T by chance. The mean that
// was seen is shrunk by the share of this variance in its square (James and Stein 1961); it is zero
// where chance explains all of it.
TurnRate::Process TurnRate::process() const {
  const double shown = count_ - kCount;
  if (shown <= 0) return about(0.0);
  const double seen = sum_ / shown;
  const Process about_seen = about(seen);
  const double noise = 2 * about_seen.variance * about_seen.correlation_s / seconds_;
  const double kept = noise < seen * seen ? 1 - noise / (seen * seen) : 0.0;
  Process result = about(kept * seen);
  result.mean_variance = kept * noise;
  return result;
}

// An Ornstein-Uhlenbeck process of time tau and mean m that is known at both ends has at t the mean
// m + ((before - m) sinh((T - t) / tau) + (after - m) sinh(t / tau)) / sinh(T / tau). While the
// robot stands it turns no laps: m is 0 there.
double TurnRate::turn(double gap_s, Ends ends, double from, double to, double moves) const {
  const Process p = process();
  const double tau = p.correlation_s;
  // Of sinh(t / tau) / sinh(T / tau), from 0 to t.
  const auto integral = [&](double t) {
    const double less = std::expm1(-t / tau);
    return tau * std::exp((t - gap_s) / tau) * less * less / -std::expm1(-2 * gap_s / tau);
  };
  const double mean = moves * p.mean;
  return mean * (to - from) + (ends.after - mean) * (integral(to) - integral(from)) +
         (ends.before - mean) * (integral(gap_s - from) - integral(gap_s - to));
}

double TurnRate::variance(double gap_s) const {
  const Process p = process();
  const double tau = p.correlation_s, by_ends_s = 2 * tau * std::tanh(gap_s / (2 * tau));
  return 2 * p.variance * tau * (gap_s - by_ends_s) +
         p.mean_variance * std::pow(gap_s - by_ends_s, 2);
}

}  // namespace gprodom
