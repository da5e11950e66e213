// A made-up robot that drives the same route through a yard again and again: IMU, wheel and radar
// made as they are asked for, so that days of data need no log. Ground and route are those of its
// seed; noise, the way beside the route, slip and biases are fresh in each round.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "estimation/planar_geometry.h"
#include "gprodom/input.h"

namespace gprodom {

// Closed, 400 m long, with bends to both sides: a circle whose radius swings three times a round.
class YardRoute {
 public:
  static constexpr double kLength = 400.0;  // m

  YardRoute() {
    double length = 0.0;
    for (std::size_t i = 0; i < kEntries; ++i) {
      along_[i] = length;
      length += speed(kStep * (static_cast<double>(i) + 0.5)) * kStep;
    }
    along_[kEntries] = length;
    radius_ = kLength / length;
    for (double& along : along_) along *= radius_;
  }

  // m for each rad of the angle.
  double speed(double angle) const { return radius_ * std::hypot(swing(angle), d_swing(angle)); }
  Eigen::Vector2d position(double angle) const {
    return radius_ * swing(angle) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  double heading(double angle) const { return angle + std::atan2(swing(angle), d_swing(angle)); }
  double curvature(double angle) const {
    const double r = swing(angle), d = d_swing(angle), dd = -kSwing * 9.0 * std::cos(3.0 * angle);
    return (r * r + 2.0 * d * d - r * dd) / (radius_ * std::pow(r * r + d * d, 1.5));
  }
  // m along the route, from 0 to kLength.
  double along(double angle) const {
    const double turn = 2.0 * M_PI;
    const double at = (angle - turn * std::floor(angle / turn)) / kStep;
    const auto i = std::min(static_cast<std::size_t>(at), kEntries - 1);
    return along_[i] + (at - static_cast<double>(i)) * (along_[i + 1] - along_[i]);
  }

 private:
  static constexpr double kSwing = 0.25;
  static constexpr std::size_t kEntries = 8192;
  static constexpr double kStep = 2.0 * M_PI / static_cast<double>(kEntries);
  static double swing(double angle) { return 1.0 + kSwing * std::cos(3.0 * angle); }
  static double d_swing(double angle) { return -kSwing * 3.0 * std::sin(3.0 * angle); }

  double radius_ = 1.0;
  std::array<double, kEntries + 1> along_{};
};

// Point reflectors beside and under the route, seen as Ricker wavelets of 500 MHz beside a direct
// wave, 201 samples of 0.2 ns. A way aside changes their ranges, as it does over real ground.
class YardGround {
 public:
  static constexpr int kSamples = 201;
  static constexpr double kInterval = 0.2e-9;  // s

  explicit YardGround(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (std::size_t i = 0; i < kCells * kEach; ++i) {
      const double along = kCell * (static_cast<double>(i / kEach) + uniform(random));
      const double aside = 1.2 * (uniform(random) - 0.5), depth = 0.1 + 1.2 * uniform(random);
      reflectors_.push_back({along, aside, depth, 1500.0 * (uniform(random) - 0.5)});
    }
    for (int phase = 0; phase < kPhases; ++phase) {
      for (int i = 0; i < kWavelet; ++i) {
        const double centre = kWavelet / 2 + static_cast<double>(phase) / kPhases;
        const double u = M_PI * 500e6 * (i - centre) * kInterval;
        wavelets_[phase][i] = static_cast<float>((1.0 - 2.0 * u * u) * std::exp(-u * u));
      }
    }
  }

  // Counts, the whole trace `delay` samples later.
  std::vector<float> trace(double along, double aside, double delay) const {
    std::vector<float> samples(kSamples, 0.0F);
    add(12.0 + delay, 15000.0, samples);
    const auto middle = static_cast<std::ptrdiff_t>(std::floor(along / kCell));
    const auto reach = static_cast<std::ptrdiff_t>(0.8 / kCell);
    for (std::ptrdiff_t cell = middle - reach; cell <= middle + reach; ++cell) {
      const auto from = static_cast<std::size_t>((cell + static_cast<std::ptrdiff_t>(kCells)) %
                                                 static_cast<std::ptrdiff_t>(kCells));
      for (std::size_t i = from * kEach; i < (from + 1) * kEach; ++i) {
        const Reflector& r = reflectors_[i];
        const double ahead = std::remainder(r.along - along, YardRoute::kLength);
        const double range2 =
            ahead * ahead + (r.aside - aside) * (r.aside - aside) + r.depth * r.depth;
        add(12.0 + 2.0 * std::sqrt(range2) / kWaveSpeed / kInterval + delay,
            r.amplitude * 0.3 / (0.3 + range2), samples);
      }
    }
    return samples;
  }

 private:
  struct Reflector {
    double along, aside, depth, amplitude;
  };
  static constexpr double kCell = 0.1, kWaveSpeed = 1e8;  // m, m/s
  static constexpr std::size_t kCells = 4000, kEach = 3;
  static constexpr int kWavelet = 32, kPhases = 64;

  void add(double centre, double amplitude, std::vector<float>& samples) const {
    const double first = centre - kWavelet / 2;
    const int from = static_cast<int>(std::floor(first));
    const auto& wavelet = wavelets_[static_cast<std::size_t>((first - from) * kPhases)];
    const int begin = std::max(0, -from), end = std::min(kWavelet, kSamples - from);
    for (int i = begin; i < end; ++i)
      samples[static_cast<std::size_t>(from + i)] += static_cast<float>(amplitude) * wavelet[i];
  }

  std::vector<Reflector> reflectors_;
  std::array<std::array<float, kWavelet>, kPhases> wavelets_{};
};

class YardRobot {
 public:
  static constexpr TimeNs kStart = 1'700'000'000'000'000'000;

  // speed: m/s; rest: s, of standing before each round.
  YardRobot(unsigned seed, double speed, double rest)
      : most_mps_(speed),
        rest_s_(rest),
        random_(seed + 1),
        ground_(seed),
        now_(at_state()),
        start_(now_.pose) {
    for (float& value : noise_) value = static_cast<float>(normal_(random_));
    gyro_bias_ = 0.003 * three();
    accel_bias_ = 0.03 * three();
  }

  // The messages of the next second, in time order.
  std::vector<Input> next_second() {
    std::vector<Input> inputs;
    for (int i = 0; i < kImuRate; ++i) step(inputs);
    return inputs;
  }

  // Of the newest IMU sample: its time, and the robot's pose in the frame of its first pose.
  TimeNs time() const { return told_.time; }
  PlanarPose pose() const { return between(start_, told_.pose); }
  double along() const { return told_along_; }  // m of the route, from 0 to its length
  bool moves() const { return told_.velocity.norm() > 0.0; }
  int rounds() const { return rounds_; }

 private:
  static constexpr int kImuRate = 50, kStepsAWheel = 2;  // 50, 25 Hz
  // A trace each so many metres or, while it stands, so many seconds.
  static constexpr double kTraceEvery = 0.035, kTraceStanding = 0.4;
  static constexpr double kDt = 1.0 / kImuRate;
  static constexpr double kAcceleration = 0.3;                 // m/s^2
  static constexpr double kAside = 0.10, kAsideOver = 6.0;     // m, sigma and length of the wander
  static constexpr double kScale = 1.01, kWheelNoise = 0.004;  // of the wheel; m/sqrt(m)
  static constexpr double kSurface = 0.005, kSurfaceOver = 5.0;  // of its scale; m

  struct State {
    TimeNs time = kStart;
    PlanarPose pose;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  };

  double normal() { return normal_(random_); }
  Eigen::Vector3d three() { return {normal(), normal(), normal()}; }

  State at_state() const {
    const double heading = route_.heading(angle_), curvature = route_.curvature(angle_);
    const Eigen::Vector2d left(-std::sin(heading), std::cos(heading));
    const double ahead = 1.0 - curvature * aside_[2], slope = d_aside();
    State state;
    state.time = kStart + steps_ * static_cast<TimeNs>(1e9 * kDt);
    state.pose = {route_.position(angle_) + aside_[2] * left, heading + std::atan2(slope, ahead)};
    state.velocity = speed_ * std::hypot(ahead, slope) *
                     Eigen::Vector2d(std::cos(state.pose.yaw), std::sin(state.pose.yaw));
    return state;
  }

  // The wander is white noise along the way behind three filters in a row, so that the curvature
  // of the track is continuous.
  double d_aside() const { return (aside_[1] - aside_[2]) / kAsideOver; }
  void wander(double ds) {
    const double white = std::sqrt(16.0 / 3.0 * kAsideOver / ds) * kAside * normal();
    const double share = ds / kAsideOver;
    aside_[2] += share * (aside_[1] - aside_[2]);
    aside_[1] += share * (aside_[0] - aside_[1]);
    aside_[0] += share * (white - aside_[0]);
  }

  // Stands, speeds up, and stops at the end of the round.
  void drive() {
    const double left = YardRoute::kLength - done_m_;
    const double most = std::min(most_mps_, std::sqrt(2.0 * kAcceleration * std::max(0.0, left)));
    stood_s_ += kDt;
    if (stood_s_ < rest_s_) return;
    speed_ = std::min(speed_ + kAcceleration * kDt, most);
    const double ds = speed_ * kDt;
    if (left < 1e-3 || ds < 1e-5) {
      done_m_ = stood_s_ = speed_ = 0.0;
      ++rounds_;
      return;
    }
    done_m_ += ds;
    angle_ += ds / route_.speed(angle_ + 0.5 * ds / route_.speed(angle_));
    wander(ds);
  }

  // Metres that the wheel reports for this way: its scale, the surface, and slip now and then.
  void turn_wheel(double way) {
    if (way <= 0.0) return;
    surface_ +=
        -way / kSurfaceOver * surface_ + kSurface * std::sqrt(2.0 * way / kSurfaceOver) * normal();
    if (slips_m_ <= 0.0 && uniform_(random_) < way / 150.0) {  // one in 150 m
      slips_m_ = 3.0 + 5.0 * uniform_(random_);
      slip_ = 0.05 + 0.15 * uniform_(random_);
    }
    slips_m_ -= way;
    const double slip = slips_m_ > 0.0 ? slip_ : 0.0;
    wheel_m_ += kScale * (1.0 + surface_ + slip) * way + kWheelNoise * std::sqrt(way) * normal();
  }

  // A sample tells of the time from its stamp to the next.
  void step(std::vector<Input>& inputs) {
    told_ = now_;
    told_along_ = route_.along(angle_);
    const double shaken = now_.velocity.norm() * std::sqrt(kImuRate);
    const double along = told_along_, aside = aside_[2];
    ++steps_;
    drive();
    const State next = at_state();
    ImuSample imu;
    imu.time = now_.time;
    const Eigen::Vector2d a =
        Eigen::Rotation2Dd(-now_.pose.yaw) * ((next.velocity - now_.velocity) / kDt);
    gyro_bias_ += 1e-6 * std::sqrt(kDt) * three();
    accel_bias_ += 1e-5 * std::sqrt(kDt) * three();
    imu.acceleration = Eigen::Vector3d(a.x(), a.y(), 9.80665) + accel_bias_ +
                       std::hypot(6e-4 * std::sqrt(kImuRate), 0.03 * shaken) * three();
    imu.angular_velocity = Eigen::Vector3d(0, 0, wrapped(next.pose.yaw - now_.pose.yaw) / kDt) +
                           gyro_bias_ +
                           std::hypot(1.6e-4 * std::sqrt(kImuRate), 0.0006 * shaken) * three();
    inputs.emplace_back(imu);
    if (steps_ % kStepsAWheel == 0) inputs.emplace_back(WheelSample{now_.time, wheel_m_});
    since_trace_m_ += now_.velocity.norm() * kDt;
    since_trace_s_ += kDt;
    if (since_trace_m_ >= kTraceEvery || since_trace_s_ >= kTraceStanding) {
      since_trace_m_ = since_trace_s_ = 0.0;
      inputs.emplace_back(measure(along, aside));
    }
    turn_wheel((next.pose.p - now_.pose.p).norm());
    now_ = next;
  }

  // White noise, a gain, a time zero and an offset of its own.
  GprTrace measure(double along, double aside) {
    GprTrace trace;
    trace.time = now_.time;
    trace.seq = ++seq_;
    trace.sample_interval_s = YardGround::kInterval;
    trace.samples = ground_.trace(along, aside, 0.15 * normal());
    const auto gain = static_cast<float>(1.0 + 0.003 * normal());
    auto offset = static_cast<float>(100.0 * normal());
    const float decay = std::exp(-1.0F / 60.0F);
    std::size_t i = random_() % noise_.size();
    for (float& sample : trace.samples) {
      sample = std::round(gain * sample + offset + 60.0F * noise_[i++ % noise_.size()]);
      offset *= decay;
    }
    return trace;
  }

  const double most_mps_, rest_s_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  std::vector<float> noise_ = std::vector<float>(1 << 16);
  YardRoute route_;
  YardGround ground_;
  Eigen::Vector3d gyro_bias_, accel_bias_;

  double angle_ = 0.0, speed_ = 0.0, done_m_ = 0.0, stood_s_ = 0.0;
  std::array<double, 3> aside_{};  // m, behind each filter
  double since_trace_m_ = 0.0, since_trace_s_ = 0.0;
  double wheel_m_ = 0.0, surface_ = 0.0, slips_m_ = 0.0, slip_ = 0.0;
  int rounds_ = 0;
  TimeNs steps_ = 0;
  std::int64_t seq_ = 0;
  State now_, told_;
  double told_along_ = 0.0;
  PlanarPose start_;
};

}  // namespace gprodom
