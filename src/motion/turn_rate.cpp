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
constexpr double kShortest_s = 0.3, kLongest_s = 10.0;
constexpr TimeNs kLag = 1'000'000'000, kJitter = 100'000'000;

// Share of a gap's variance that its first part has, by the part's length over the gap's: the turn
// is known at both ends, so it grows in the middle.
double share(double part) {
  const double u = std::clamp(part, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

}  // namespace

TurnRate::TurnRate()
    : square_(kCount * kRate * kRate),
      product_(square_ * std::exp(-to_seconds(kLag) / kCorrelation_s)),
      count_(kCount) {}

void TurnRate::complete(StateInput& input, TimeNs from, const Eigen::Vector3d& gyro_bias,
                        const ImuHistory& imu) {
  if (!imu_silent(input.steps)) {
    double turned = 0.0;
    for (const MotionStep& step : input.steps)
      turned += (step.angular_velocity - gyro_bias).z() * step.dt;
    learn(turned / to_seconds(input.time - from), input.time);
    return;
  }
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
                         since, since + step.dt);
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
    count_ += 1;
  }
  recent_.push_back({to, rate});
}

double TurnRate::correlation_s() const {
  const double lag_s = to_seconds(kLag);
  const double correlation = std::max(product_ / square_, std::exp(-lag_s / kShortest_s));
  return std::min(-lag_s / std::log(correlation), kLongest_s);
}

// An Ornstein-Uhlenbeck process of time tau that is known at both ends has at t the mean
// (before sinh((T - t) / tau) + after sinh(t / tau)) / sinh(T / tau).
double TurnRate::turn(double gap_s, Ends ends, double from, double to) const {
  const double tau = correlation_s();
  // Of sinh(t / tau) / sinh(T / tau), from 0 to t.
  const auto integral = [&](double t) {
    const double less = std::expm1(-t / tau);
    return tau * std::exp((t - gap_s) / tau) * less * less / -std::expm1(-2 * gap_s / tau);
  };
  return ends.after * (integral(to) - integral(from)) +
         ends.before * (integral(gap_s - from) - integral(gap_s - to));
}

double TurnRate::variance(double gap_s) const {
  const double tau = correlation_s();
  return 2 * square_ / count_ * tau * (gap_s - 2 * tau * std::tanh(gap_s / (2 * tau)));
}

}  // namespace gprodom
