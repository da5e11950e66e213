// Ranges to beacons as factors of one's own: beacons [RUNS]
//
// A simulated robot with a cheap gyro and a wheel of unknown scale drives for two minutes among
// three radio beacons whose places in `odom` are known, once without their ranges and once with
// them. Printed are the errors at the end of the drives and, with the ranges, the NEES of the
// position: its mean over many runs is 2 where the covariance is right. Exit code 1 where the
// ranges do not help, or the mean is out of the band that holds it in 19 of 20 cases.
#include <ceres/autodiff_cost_function.h>
#include <gprodom/odometry.h>
#include <gprodom/user_factor.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace {

using Eigen::Vector3d;

constexpr double kStep = 0.01;                          // s, of the IMU
constexpr double kStanding = 3.0, kEnd = 120.0;         // s
constexpr double kGyroNoise = 5e-4;                     // rad/s/sqrt(Hz)
constexpr double kAccelNoise = 2e-3;                    // m/s^2/sqrt(Hz)
constexpr double kScaleSigma = 0.02;                    // of the wheel
constexpr double kRangeSigma = 0.1, kRangeEvery = 0.5;  // m, s
constexpr gprodom::TimeNs kStart = 1'700'000'000'000'000'000;
const Vector3d kBeacons[] = {{20, 10, 2}, {-15, 15, 2}, {0, -20, 2}};  // m, in odom

// The residual, of unit variance. Ceres derives it by the position itself.
struct Range {
  Vector3d beacon;
  double measured_m;
  template <typename T>
  bool operator()(const T* p_odom, T* residual) const {
    const Eigen::Matrix<T, 3, 1> way =
        Eigen::Map<const Eigen::Matrix<T, 3, 1>>(p_odom) - beacon.cast<T>();
    residual[0] = (way.norm() - measured_m) / kRangeSigma;
    return true;
  }
};

gprodom::UserFactor range_factor(gprodom::TimeNs time, const Vector3d& beacon, double measured_m) {
  gprodom::UserFactor factor;
  factor.name = "beacon";
  factor.times = {time};
  factor.blocks = {{0, gprodom::StatePart::kPosition}};
  factor.cost =
      std::make_shared<ceres::AutoDiffCostFunction<Range, 1, 3>>(new Range{beacon, measured_m});
  factor.loss = std::make_shared<ceres::CauchyLoss>(3.0);  // a range may be off by metres
  return factor;
}

// True position and speed of the robot: it stands, then drives wide bends.
struct Truth {
  double time = 0, yaw = 0, speed = 0, distance = 0;
  Vector3d p = Vector3d::Zero();
  static double speed_at(double t) {
    return t < kStanding ? 0.0 : 0.4 * (1 - std::cos(0.5 * (t - kStanding)));
  }
  static double turn_at(double t) { return t < kStanding ? 0.0 : 0.2 * std::sin(0.07 * t); }
  void advance() {
    const double middle = time + kStep / 2, way = speed_at(middle) * kStep;
    const double heading = yaw + turn_at(middle) * kStep / 2;
    p += way * Vector3d(std::cos(heading), std::sin(heading), 0);
    yaw += turn_at(middle) * kStep;
    distance += way;
    time += kStep;
    speed = speed_at(time);
  }
  double acceleration() const { return (speed_at(time + 1e-4) - speed_at(time - 1e-4)) / 2e-4; }
};

struct Outcome {
  double error_m, nees;
};

Outcome drive(unsigned seed, bool with_ranges) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> n;
  const auto white = [&](double density) -> Vector3d {
    return density / std::sqrt(kStep) * Vector3d(n(engine), n(engine), n(engine));
  };
  gprodom::Config config = gprodom::default_config();
  config.gpr.enabled = false;
  config.imu.gyro_noise_density = kGyroNoise;
  config.imu.accel_noise_density = kAccelNoise;
  config.wheel.scale_sigma = kScaleSigma;
  // This wheel has no resolution to speak of and never slips, and the robot does not slip sideways.
  config.wheel.noise_floor = 1e-5;
  config.wheel.slip_share = 0;
  config.wheel.lateral_noise = config.wheel.vertical_noise = 3e-4;
  gprodom::Odometry odometry(config);

  const double scale = 1 + kScaleSigma * n(engine);
  std::mt19937 range_engine(seed + 1000);
  Truth truth;
  double reported_m = 0, next_range = kStanding + kRangeEvery;
  gprodom::OdometryEstimate estimate;
  while (truth.time < kEnd) {
    const double before = truth.distance;
    truth.advance();
    const gprodom::TimeNs now = kStart + gprodom::from_seconds(truth.time);
    const double way = truth.distance - before;
    reported_m += scale * way + config.wheel.noise * std::sqrt(way) * n(engine);
    gprodom::ImuSample imu;
    imu.time = now;
    imu.acceleration =
        Vector3d(truth.acceleration(), truth.speed * Truth::turn_at(truth.time), 9.80665) +
        white(kAccelNoise);
    imu.angular_velocity = Vector3d(0, 0, Truth::turn_at(truth.time)) + white(kGyroNoise);
    odometry.add(imu);
    odometry.add(gprodom::WheelSample{now, reported_m});
    if (with_ranges && truth.time >= next_range) {
      next_range += kRangeEvery;
      for (const Vector3d& beacon : kBeacons) {
        const double measured = (truth.p - beacon).norm() + kRangeSigma * n(range_engine);
        const std::string refusal = odometry.add_factor(range_factor(now, beacon, measured));
        if (!refusal.empty()) std::fprintf(stderr, "range refused: %s\n", refusal.c_str());
      }
    }
    const gprodom::Outputs out = odometry.step();
    for (const std::string& warning : out.warnings) std::fprintf(stderr, "%s\n", warning.c_str());
    if (!out.odometry.empty()) estimate = out.odometry.back();
  }
  const Eigen::Vector2d error = (estimate.p_odom_body - truth.p).head<2>();
  const Eigen::Matrix2d covariance = estimate.pose_covariance.topLeftCorner<2, 2>();
  return {error.norm(), error.dot(covariance.inverse() * error)};
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 1;
  if (runs < 1) return 2;
  double without = 0, with = 0, nees = 0;
  for (int run = 0; run < runs; ++run) {
    without += std::pow(drive(run, false).error_m, 2) / runs;
    const Outcome ranged = drive(run, true);
    with += std::pow(ranged.error_m, 2) / runs;
    nees += ranged.nees / runs;
  }
  const double band = 1.96 * 2 / std::sqrt(runs);  // NEES of two axes: mean 2, variance 4
  std::printf("%d runs: error %.3f m without ranges, %.3f m with them (RMS); NEES %.2f", runs,
              std::sqrt(without), std::sqrt(with), nees);
  std::printf(runs < 10 ? "\n" : ", band %.2f to %.2f\n", 2 - band, 2 + band);
  return with < without && (runs < 10 || std::abs(nees - 2) < band) ? 0 : 1;
}
