// Sends gprodomd what the drivers of a robot send: send [SECONDS [URL]]
//
// IMU, wheel and radar of a made-up robot, for SECONDS (0: without end), to LCM at URL. It stands
// for three seconds, which the estimator needs for its start, and then drives three metres to and
// fro. Put your own drivers in place of the class Robot; what is sent, and how it is stamped, stays
// as it is.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <random>
#include <thread>
#include <vector>

#include "gprodom/gpr_trace_t.hpp"
#include "gprodom/imu_t.hpp"
#include "gprodom/wheel_t.hpp"

namespace {

using Clock = std::chrono::system_clock;  // stamps are microseconds since 1970

constexpr std::chrono::milliseconds kImuPeriod(10);
constexpr long kEvery = 5;  // wheel and radar: one message every so many of the IMU
constexpr double kMetresPerTick = 0.0002;
constexpr double kSampleInterval = 2e-10;  // s

// A robot over made-up ground; times in seconds since it was switched on.
class Robot {
 public:
  struct Imu {
    std::array<double, 3> force, rate;
  };

  Robot() {
    std::uniform_real_distribution<double> along(-1.0, 4.5), away(0.2, 1.5), strength(-1.0, 1.0);
    for (int i = 0; i < 120; ++i)
      stones_.push_back({along(random_), away(random_), strength(random_)});
  }

  // Along the track (m), forwards positive: what an encoder counts.
  static double distance(double t) {
    return kFastest * kThereAndBack / (2 * M_PI) * (1 - std::cos(phase(t)));
  }

  // Specific force (m/s^2) and angular velocity (rad/s) in the axes of the IMU. At rest on level
  // ground the force points up, with the size of gravity.
  Imu read_imu(double t) {
    const double change = kFastest * 2 * M_PI / kThereAndBack * std::cos(phase(t));
    Imu imu{{t > kStands ? change : 0.0, 0.0, 9.81}, {}};
    for (double& f : imu.force) f += 0.01 * noise_(random_);
    for (double& w : imu.rate) w += 0.002 * noise_(random_);
    return imu;
  }

  // One trace in counts: the direct wave, and the echo of each stone.
  std::vector<std::int32_t> read_trace(double t) {
    std::vector<double> counts(201);
    for (double& count : counts) count = 10 * noise_(random_);
    add_echo(counts, 8000, 4e-9);
    for (const Stone& stone : stones_) {
      const double path_m = 2 * std::hypot(stone.along_m - distance(t), stone.away_m);
      add_echo(counts, 2000 * stone.strength / (1 + path_m), path_m / 1e8);  // moist soil: 1e8 m/s
    }
    std::vector<std::int32_t> samples;
    for (const double count : counts) samples.push_back(static_cast<std::int32_t>(count));
    return samples;
  }

 private:
  struct Stone {
    double along_m, away_m, strength;
  };
  static constexpr double kStands = 3.0, kThereAndBack = 20.0;  // s
  static constexpr double kFastest = 0.5;                       // m/s

  // Of the drive to and fro (rad).
  static double phase(double t) { return 2 * M_PI * std::max(0.0, t - kStands) / kThereAndBack; }

  // A Ricker wavelet of 400 MHz.
  static void add_echo(std::vector<double>& counts, double strength, double arrival) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double since = static_cast<double>(i) * kSampleInterval - arrival;
      const double pulse = std::pow(M_PI * 4e8 * since, 2);
      counts[i] += strength * (1 - 2 * pulse) * std::exp(-pulse);
    }
  }

  std::mt19937 random_{1};
  std::normal_distribution<double> noise_;
  std::vector<Stone> stones_;
};

void publish(lcm::LCM& lcm, Robot& robot, long number, std::int64_t utime, double t) {
  const Robot::Imu read = robot.read_imu(t);
  gprodom::imu_t imu{};
  imu.utime = utime;
  std::copy(read.force.begin(), read.force.end(), imu.linear_acceleration);
  std::copy(read.rate.begin(), read.rate.end(), imu.angular_velocity);
  lcm.publish("IMU", &imu);
  if (number % kEvery != 0) return;

  gprodom::wheel_t wheel{};
  wheel.utime = utime;
  wheel.ticks = std::lround(Robot::distance(t) / kMetresPerTick);  // never set back to zero
  wheel.metres_per_tick = kMetresPerTick;
  lcm.publish("WHEEL", &wheel);

  gprodom::gpr_trace_t trace{};
  trace.utime = utime;
  trace.seq = number / kEvery;
  trace.sample_interval = kSampleInterval;
  trace.samples = robot.read_trace(t);
  trace.num_samples = static_cast<std::int32_t>(trace.samples.size());
  lcm.publish("GPR_TRACE", &trace);
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 0.0;
  lcm::LCM lcm(argc > 2 ? argv[2] : "udpm://239.255.76.67:7667?ttl=0");
  if (!lcm.good()) return 1;
  Robot robot;
  const auto begin = Clock::now();
  for (long number = 0;; ++number) {
    std::this_thread::sleep_until(begin + number * kImuPeriod);
    // The stamp is the time at which the values were taken, not the time of sending.
    const auto now = Clock::now();
    const double t = std::chrono::duration<double>(now - begin).count();
    if (seconds > 0 && t >= seconds) return 0;
    const auto since_1970 =
        std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch());
    publish(lcm, robot, number, since_1970.count(), t);
  }
}
