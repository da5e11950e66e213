// The wheel's correction of a predicted pose: its derivative against numeric ones, and its
// covariance against drawn errors.
#include "estimation/predict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "estimation/kernels/so3.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 0.005;  // s
const Vector3d kForce(1.2, 0.3, 9.9), kRate(0.02, -0.03, 0.5);

NavState state() {
  NavState x;
  x.q_odom_body = so3::exp(Vector3d(0.03, -0.02, 0.7));
  x.p_odom = {3, -2, 0.1};
  x.v_odom = x.q_odom_body * Vector3d(0.8, 0, 0);
  x.gyro_bias = {0.001, -0.002, 0.003};
  x.accel_bias = {0.02, -0.01, 0.03};
  x.wheel_scale = 1.02;
  return x;
}

// What the IMU has integrated since a state, and the way on it.
struct Since {
  ImuPreintegration imu;
  PredictedWay way;
};

// Held force and rate, with errors of a seed if there is one.
Since integrated(const NavState& x, const ImuNoise& noise, double seconds,
                 std::optional<unsigned> seed = std::nullopt) {
  Since since{{noise, x.gyro_bias, x.accel_bias}, way_begins(x)};
  Noise errors(seed.value_or(0));
  const auto error = [&](double density) -> Vector3d {
    return errors.vector(seed ? density / std::sqrt(kStep) : 0.0);
  };
  for (double t = 0; t < seconds - 1e-9; t += kStep) {
    const Vector3d of_force = error(noise.accel_density), of_rate = error(noise.gyro_density);
    since.imu.integrate(kForce + of_force, kRate + of_rate, kStep);
    since.way = way_further(since.way, x, since.imu, Vector3d::Zero(), kStandardGravity);
  }
  return since;
}

// The biases of the integration stay; those of the state change.
Vector3d moved(const NavState& x, const NavState& linearised) {
  ImuPreintegration since({1e-3, 1e-2, 0}, linearised.gyro_bias, linearised.accel_bias);
  PredictedWay way = way_begins(x);
  for (double t = 0; t < 0.3 - 1e-9; t += kStep) {
    since.integrate(kForce, kRate, kStep);
    way = way_further(way, x, since, Vector3d::Zero(), kStandardGravity);
  }
  return way.moved_m;
}

TEST(PredictedWay, DerivativeByTheState) {
  const NavState x = state();
  const PredictedWay way = integrated(x, {1e-3, 1e-2, 0}, 0.3).way;
  EXPECT_NEAR(way.moved_m.x(), 0.8 * 0.3 + 0.5 * 1.2 * 0.09, 0.02);
  EXPECT_NEAR(way.turned_rad, 0.5 * 0.3, 0.01);
  for (int i = 0; i < row::kScale; ++i) {
    const StateVector h = 1e-4 * StateVector::Unit(i);
    const Vector3d numeric = (moved(retract(x, h), x) - moved(retract(x, -h), x)) / 2e-4;
    // The largest entry, of the velocity, is 0.3 s. The axes at half the turn stand for all. What
    // is left out: a gyro bias turns the axes, so 0.3 m ahead lie aside by 0.3 m * 0.15 s.
    for (int axis = 0; axis < 3; ++axis) {
      const bool turned = (i == row::kBg + 2 && axis == 1) || (i == row::kBg + 1 && axis == 2);
      EXPECT_NEAR(way.d_state(i, axis), numeric[axis], turned ? 0.05 : 0.01)
          << "row " << i << ", axis " << axis;
    }
  }
}

// A wheel rolls along a bend, not along its chord, and moves nowhere sideways, however the bend
// changes.
TEST(PredictedWay, IsAlongThePath) {
  NavState x;
  x.v_odom = {1.0, 0, 0};
  ImuPreintegration since({1e-3, 1e-2, 0}, Vector3d::Zero(), Vector3d::Zero());
  PredictedWay way = way_begins(x);
  double rate = -2.0;  // rad/s
  for (int k = 0; k < 100; ++k, rate += 0.04) {
    const double middle = rate + 0.02;
    since.integrate({0, middle, kStandardGravity}, {0, 0, middle}, kStep);
    way = way_further(way, x, since, Vector3d::Zero(), kStandardGravity);
  }
  EXPECT_NEAR(way.moved_m.x(), 0.5, 1e-4);
  EXPECT_NEAR(way.moved_m.y(), 0.0, 1e-4);
}

// A robot that turns on the spot rolls the contact point of a wheel at its side, and of no other.
TEST(PredictedWay, IsThatOfTheContactPoint) {
  NavState x;
  const auto way = [&](const Vector3d& contact) {
    ImuPreintegration since({1e-3, 1e-2, 0}, Vector3d::Zero(), Vector3d::Zero());
    PredictedWay on = way_begins(x);
    for (int k = 0; k < 60; ++k) {
      since.integrate({0, 0, kStandardGravity}, {0, 0, 1.0}, kStep);
      on = way_further(on, x, since, contact, kStandardGravity);
    }
    return on.moved_m.x();
  };
  EXPECT_NEAR(way(Vector3d::Zero()), 0.0, 1e-9);
  EXPECT_NEAR(way({0, 0.5, 0}), -0.5 * 0.3, 1e-5);
}

// True states, IMU samples and distances of the wheel are drawn. The wheel is heard 0.1 s before
// the pose that is published.
TEST(TakeWheel, CovarianceIsThatOfTheErrors) {
  const ImuNoise noise{2e-3, 0.3, 0};
  const Vector3d wheel_sigma_m(0.004, 0.002, 0.003);
  StateVector sigma;
  sigma << Vector3d(0.01, 0.01, 0.02), Vector3d(0.02, 0.02, 0.01), Vector3d::Constant(0.05),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.1), 0.01;
  const StateMatrix covariance = sigma.array().square().matrix().asDiagonal();
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 600;
  double nees = 0;
  Vector3d square = Vector3d::Zero(), square_without = Vector3d::Zero();  // in body axes
  for (int run = 0; run < kRuns; ++run) {
    const NavState x = state();
    StateVector error;
    for (int i = 0; i < kStateDim; ++i) error[i] = sigma[i] * normal(engine);
    const NavState truth = retract(x, error);
    const unsigned draw = engine();
    // The samples are the same to both; the truth is without their noise and with its biases.
    const Since of_truth = integrated(truth, noise, 0.3);
    Vector3d true_m = integrated(truth, noise, 0.2).way.moved_m;
    const ImuPreintegration since = integrated(x, noise, 0.3, draw).imu;
    PredictedWay way = integrated(x, noise, 0.2, draw).way;
    way.time = x.time + from_seconds(0.2);
    OdometryEstimate estimate = predict(x, covariance, since, kStandardGravity);
    const NavState end = propagate(truth, of_truth.imu, kStandardGravity);
    const auto squares = [&]() -> Vector3d {
      return (end.R_odom_body().transpose() * (end.p_odom - estimate.p_odom_body)).cwiseAbs2();
    };
    square_without += squares();
    for (int i = 0; i < 3; ++i) true_m[i] += wheel_sigma_m[i] * normal(engine);
    true_m.x() *= truth.wheel_scale;
    take_wheel(x, covariance, since, kStandardGravity, way, {true_m, wheel_sigma_m}, 0.0, estimate);
    square += squares();
    Eigen::Matrix<double, 6, 1> off;
    off << end.p_odom - estimate.p_odom_body,
        so3::log(end.q_odom_body * estimate.q_odom_body.conjugate());
    nees += off.dot(estimate.pose_covariance.ldlt().solve(off));
  }
  // Of six, 99.9 % of such means.
  EXPECT_NEAR(nees / kRuns, 6.0, 3.3 * std::sqrt(12.0 / kRuns));
  for (int axis = 0; axis < 3; ++axis) EXPECT_LT(square[axis], 0.9 * square_without[axis]) << axis;
}

// The scale's error moves a robot that has come far by metres. What a wheel says over 0.3 s must
// not move the pose by more than that.
TEST(TakeWheel, CorrectsTheMovementSinceTheStateAlone) {
  const NavState x = state();
  const auto [since, way] = integrated(x, {1e-3, 0.1, 0}, 0.3);
  StateVector sigma = StateVector::Constant(1e-3);
  sigma.segment<3>(row::kV).setConstant(0.1);
  sigma[row::kScale] = 0.02;
  StateMatrix covariance = sigma.array().square().matrix().asDiagonal();
  StateVector lasting = StateVector::Zero();  // an unseen error of scale and speed over 500 m
  lasting.segment<3>(row::kP).setConstant(10.0);
  lasting[row::kTheta + 2] = 0.05;
  lasting[row::kScale] = 0.02;
  lasting[row::kV] = 0.02;
  covariance += lasting * lasting.transpose();
  const OdometryEstimate alone = predict(x, covariance, since, kStandardGravity);
  OdometryEstimate estimate = alone;
  const double more_m = 0.02;
  const Vector3d more = way.moved_m + Vector3d(more_m, 0, 0);
  take_wheel(x, covariance, since, kStandardGravity, way,
             {{x.wheel_scale * more.x(), more.y(), more.z()}, Vector3d::Constant(1e-3)}, 0.0,
             estimate);
  const double moved_m = (estimate.p_odom_body - alone.p_odom_body).norm();
  EXPECT_GT(moved_m, 0.3 * more_m);
  EXPECT_LT(moved_m, 1.5 * more_m);
}

// A wheel that jumps is hardly believed.
TEST(TakeWheel, KernelHoldsBackAWheelThatJumps) {
  const NavState x = state();
  const Since since = integrated(x, {1e-4, 1e-3, 0}, 0.3);
  const StateMatrix covariance = 1e-4 * StateMatrix::Identity();
  OdometryEstimate alone = predict(x, covariance, since.imu, kStandardGravity);
  const auto pulled = [&](double threshold) {
    OdometryEstimate estimate = alone;
    Vector3d jumped_m = since.way.moved_m;
    jumped_m.x() = x.wheel_scale * (jumped_m.x() + 0.5);
    take_wheel(x, covariance, since.imu, kStandardGravity, since.way,
               {jumped_m, Vector3d::Constant(1e-3)}, threshold, estimate);
    return (estimate.p_odom_body - alone.p_odom_body).norm();
  };
  EXPECT_LT(pulled(1.5), 0.1 * pulled(0.0));
}

}  // namespace
}  // namespace gprodom
