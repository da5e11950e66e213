// What the estimator's parts cost on one core: each IMU sample, each factor with its Jacobians, a
// state's update against the lag, the pose graph against its length.
//   build/bench/bench_estimation
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <vector>

#include "estimation/factors.h"
#include "estimation/graph/pose_graph.h"
#include "estimation/marginal_prior.h"
#include "estimation/planar_steps.h"
#include "estimation/predict.h"
#include "estimation/state_estimator.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.80665;
constexpr double kImuStep = 0.005;      // s
constexpr double kStateInterval = 0.1;  // s
constexpr double kSpeed = 0.5;          // m/s
constexpr ImuNoise kNoise{1.6e-4, 5.9e-4};

// A bend driven at constant speed, with some vibration.
MotionStep motion(int i) {
  MotionStep step;
  step.dt = kImuStep;
  step.angular_velocity = {0.01 * std::sin(i), 0.01 * std::cos(2.0 * i), 0.2};
  step.acceleration = {0.1 * std::sin(3.0 * i), 0.2 * kSpeed, kGravity + 0.1 * std::cos(5.0 * i)};
  step.wheel_m = kSpeed * kImuStep;
  return step;
}

InitialState at_start() {
  InitialState initial;
  initial.noise = kNoise;
  initial.state.v_odom = {kSpeed, 0, 0};
  StateVector sigma;
  sigma << Vector3d::Constant(1e-3), Vector3d::Constant(1e-3), Vector3d::Constant(2e-3),
      Vector3d::Constant(2e-4), Vector3d::Constant(0.03), 0.02;
  initial.prior = gaussian_prior(initial.state, sigma.cwiseAbs2().asDiagonal());
  return initial;
}

// The next state's input, of a robot that drives on.
class Driver {
 public:
  StateInput next() {
    StateInput input;
    input.time = time_ += from_seconds(kStateInterval);
    input.noise = kNoise;
    input.has_wheel = true;
    for (double t = 0; t < kStateInterval - 1e-9; t += kImuStep)
      input.steps.push_back(motion(i_++));
    return input;
  }

 private:
  TimeNs time_ = 0;
  int i_ = 0;
};

ImuPreintegration preintegrated() {
  ImuPreintegration imu(kNoise, Vector3d::Zero(), Vector3d::Zero());
  for (int i = 0; i < 20; ++i) {
    const MotionStep step = motion(i);
    imu.integrate(step.acceleration, step.angular_velocity, step.dt);
  }
  return imu;
}

void imu_sample(benchmark::State& state) {
  ImuPreintegration imu(kNoise, Vector3d::Zero(), Vector3d::Zero());
  int i = 0;
  for (auto _ : state) {
    const MotionStep step = motion(i++);
    imu.integrate(step.acceleration, step.angular_velocity, step.dt);
    benchmark::DoNotOptimize(imu);
  }
}
BENCHMARK(imu_sample)->Unit(benchmark::kMicrosecond);

void wheel_step(benchmark::State& state) {
  WheelIncrement wheel(Vector3d::Zero());
  int i = 0;
  for (auto _ : state) {
    const MotionStep step = motion(i++);
    wheel.integrate(step.angular_velocity, step.dt, step.wheel_m);
    benchmark::DoNotOptimize(wheel);
  }
}
BENCHMARK(wheel_step)->Unit(benchmark::kMicrosecond);

// From the newest state to the newest IMU sample, as for each ODOMETRY message.
void prediction(benchmark::State& state) {
  const ImuPreintegration since = preintegrated();
  const NavState x = at_start().state;
  const StateMatrix covariance = 1e-4 * StateMatrix::Identity();
  for (auto _ : state) benchmark::DoNotOptimize(predict(x, covariance, since, kGravity));
}
BENCHMARK(prediction)->Unit(benchmark::kMicrosecond);

enum Kind { kImu, kWalk, kWheel, kWheelDistance, kStandstill, kDisplacement, kRevisit };

std::unique_ptr<Factor> make_factor(Kind kind) {
  switch (kind) {
    case kImu:
      return std::make_unique<ImuFactor>(preintegrated(), Vector3d(0, 0, -kGravity));
    case kWalk:
      return std::make_unique<RandomWalkFactor>(1e-6, 1e-5, 1e-6);
    case kWheel: {
      WheelIncrement wheel(Vector3d::Zero());
      for (int i = 0; i < 20; ++i)
        wheel.integrate(motion(i).angular_velocity, kImuStep, motion(i).wheel_m);
      return std::make_unique<WheelFactor>(wheel, Vector3d::Zero(), Vector3d::Constant(1e-6), 1.5);
    }
    case kWheelDistance:
      return std::make_unique<WheelDistanceFactor>(0.05, 0.001, Vector3d::Zero(), 1.5);
    case kStandstill:
      return std::make_unique<StandstillFactor>(StandstillSigmas{});
    case kDisplacement: {
      DisplacementFactor::Measurement m;
      m.distance_m = 0.05;
      m.sigma_m = 0.01;
      return std::make_unique<DisplacementFactor>(m, Vector3d::Zero());
    }
    case kRevisit:
      return std::make_unique<RevisitFactor>(RevisitEdge{});
  }
  return nullptr;
}

// Residual and both Jacobians.
void factor(benchmark::State& state, Kind kind) {
  const auto subject = make_factor(kind);
  NavState a = at_start().state;
  const NavState b = propagate(a, preintegrated(), kGravity);
  Residual r;
  Jacobian Ja, Jb;
  for (auto _ : state) {
    subject->evaluate(a, b, r, &Ja, &Jb);
    benchmark::DoNotOptimize(Jb);
  }
}
BENCHMARK_CAPTURE(factor, imu, kImu)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(factor, random_walk, kWalk)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(factor, wheel, kWheel)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(factor, wheel_distance, kWheelDistance)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(factor, standstill, kStandstill)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(factor, displacement, kDisplacement)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(factor, revisit, kRevisit)->Unit(benchmark::kMicrosecond);

// One state more: preintegration, factors, solve, newest covariance, marginalisation; 10 states/s.
void update(benchmark::State& state) {
  Config config = default_config();
  config.smoother.state_rate = 1 / kStateInterval;
  config.smoother.lag = static_cast<double>(state.range(0));
  StateEstimator estimator(config, at_start());
  Driver driver;
  for (int i = 0; i < 10 * state.range(0) + 20; ++i) estimator.add(driver.next());
  for (auto _ : state) {
    state.PauseTiming();
    const StateInput input = driver.next();
    state.ResumeTiming();
    benchmark::DoNotOptimize(estimator.add(input));
  }
}
BENCHMARK(update)->ArgName("lag_s")->Arg(1)->Arg(2)->Arg(3)->Arg(5)->Arg(10)->Arg(20)->Unit(
    benchmark::kMillisecond);

// The oldest state out of a prior on two.
void marginalise_one(benchmark::State& state) {
  const Eigen::MatrixXd J = Eigen::MatrixXd::Random(40, 2 * kStateDim);
  const Eigen::VectorXd r = Eigen::VectorXd::Random(40);
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  for (auto _ : state) {
    eliminate_first_state(J, r, A, b);
    benchmark::DoNotOptimize(A.data());
  }
}
BENCHMARK(marginalise_one)->Unit(benchmark::kMicrosecond);

// A line driven there and back, a node every half metre, with a revisit every 2 m of the way back.
void pose_graph(benchmark::State& state) {
  const auto nodes = static_cast<std::size_t>(state.range(0));
  for (auto _ : state) {
    state.PauseTiming();
    PoseGraph graph({}, {});
    for (std::size_t i = 0; i < nodes; ++i)
      graph.add_node(step_of({{i < nodes / 2 ? 0.5 : -0.5, 0.0}, 0.0}));
    for (std::size_t i = nodes / 2 + 4; i < nodes; i += 4)
      graph.add_revisit({nodes - i, i, {}, {}, 0.005});
    state.ResumeTiming();
    benchmark::DoNotOptimize(graph.solve(1.0, 0.02));
  }
}
BENCHMARK(pose_graph)->ArgName("nodes")->Arg(100)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gprodom
