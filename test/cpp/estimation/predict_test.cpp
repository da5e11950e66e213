// The wheel's correction of a predicted pose: its derivative against numeric ones, and its
// covariance against drawn errors.
#include "estimation/predict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "estimation/increments/imu_preintegration.h"
#include "estimation/kernels/so3.h"
#include "estimation/revised_state.h"
#include "support/derivative.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
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
  const Eigen::MatrixXd numeric = numeric_jacobian(
      kStateDim, 1e-4, [&](const StateVector& d) { return moved(retract(x, d), x); });
  for (int i = 0; i < row::kScale; ++i) {
    // The largest entry, of the velocity, is 0.3 s. The axes at half the turn stand for all. What
    // is left out: a gyro bias turns the axes, so 0.3 m ahead lie aside by 0.3 m * 0.15 s.
    for (int axis = 0; axis < 3; ++axis) {
      const bool turned = (i == row::kBg + 2 && axis == 1) || (i == row::kBg + 1 && axis == 2);
      EXPECT_NEAR(way.d_state(i, axis), numeric(axis, i), turned ? 0.05 : 0.01)
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

// The state after something was found wrong.
const Matrix3d kTurn =
    (AngleAxisd(1.9, Vector3d::UnitZ()) * AngleAxisd(0.1, Vector3d::UnitX())).toRotationMatrix();

TEST(TurnedAxes, TheImuSeesTheSameAndTheHeadingStays) {
  const NavState x = state();
  const NavState y = with_turned_axes({x, StateMatrix::Identity()}, kTurn).state;
  // Gravity in the axes of the IMU.
  const Vector3d up_old = x.q_odom_body.conjugate() * Vector3d::UnitZ(),
                 up_new = y.q_odom_body.conjugate() * Vector3d::UnitZ();
  EXPECT_LT((up_new - kTurn * up_old).norm(), 1e-12);
  const Vector3d ahead_old = x.q_odom_body * Vector3d::UnitX(),
                 ahead_new = y.q_odom_body * Vector3d::UnitX();
  EXPECT_NEAR(std::atan2(ahead_new.y(), ahead_new.x()), std::atan2(ahead_old.y(), ahead_old.x()),
              1e-12);
  EXPECT_EQ(y.p_odom, x.p_odom);
  EXPECT_EQ(y.v_odom, x.v_odom);
  EXPECT_LT((y.gyro_bias - kTurn * x.gyro_bias).norm(), 1e-15);
}

// The covariance is J P J^T; J against numeric derivatives, of all but the heading's own change by
// a tilt, which is of the second order in the slope.
TEST(TurnedAxes, CovarianceFollowsTheDerivatives) {
  NavState x = state();
  x.q_odom_body = Quaterniond(AngleAxisd(0.8, Vector3d::UnitZ()));
  const Matrix3d turn = AngleAxisd(1.9, Vector3d::UnitZ()).toRotationMatrix();
  const CarriedState at = with_turned_axes({x, StateMatrix::Identity()}, turn);
  const StateMatrix J = numeric_jacobian(kStateDim, 1e-4, [&](const StateVector& d) {
    return local(at.state, with_turned_axes({retract(x, d), StateMatrix::Identity()}, turn).state);
  });
  StateMatrix P = StateMatrix::Identity();
  P.diagonal() << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16;
  const StateMatrix numeric = J * P * J.transpose();
  EXPECT_LT((with_turned_axes({x, P}, turn).covariance - numeric).norm(), 1e-5 * numeric.norm());
}

// Preintegration against an independent integration in small steps, its covariance against numeric
// derivatives of that integration, and both against drawn noise.

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector9d = Eigen::Matrix<double, 9, 1>;

struct Sample {
  Vector3d force, rate;
};

std::vector<Sample> samples(int n, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  auto vector = [&](double size) {
    return Vector3d(size * u(engine), size * u(engine), size * u(engine));
  };
  std::vector<Sample> s;
  for (int i = 0; i < n; ++i) s.push_back({vector(3) + Vector3d(0, 0, 9.8), vector(2)});
  return s;
}

// Attitude as a matrix, and classic Runge-Kutta of R' = R [w], v' = R a, p' = v at twice the rate
// of the samples and more, which are held.
struct Motion {
  Matrix3d R = Matrix3d::Identity();
  Vector3d v = Vector3d::Zero(), p = Vector3d::Zero();

  void move(const Sample& s, double dt, int parts) {
    const double h = dt / parts;
    const Matrix3d W = so3::skew(s.rate);
    for (int i = 0; i < parts; ++i) {
      const Matrix3d k1 = R * W, k2 = (R + 0.5 * h * k1) * W, k3 = (R + 0.5 * h * k2) * W,
                     k4 = (R + h * k3) * W;
      const Matrix3d middle = R + h / 24 * (5 * k1 + 4 * k2 + 4 * k3 - k4);  // R at h/2, order 3
      const Matrix3d end = R + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      const Vector3d a0 = R * s.force, a1 = middle * s.force, a2 = end * s.force;
      p += h * v + h * h / 6 * (a0 + 2 * a1);  // Simpson
      v += h / 6 * (a0 + 4 * a1 + a2);
      R = end;
    }
  }

  // Log(R^T R'), v' - v, p' - p.
  Vector9d to(const Motion& o) const {
    Vector9d d;
    d << so3::log(Eigen::Quaterniond(R.transpose() * o.R).normalized()), o.v - v, o.p - p;
    return d;
  }
  Motion off_by(const Vector9d& d) const {
    return {R * so3::exp_matrix(d.head<3>()), v + d.segment<3>(3), p + d.tail<3>()};
  }
};

constexpr double kDt = 0.005;
constexpr int kParts = 4;
const ImuNoise kNoise{1.6e-4, 5.9e-4, 3 * 5.9e-4};

TEST(ImuPreintegration, EqualsIntegrationInSmallSteps) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    ImuPreintegration imu(kNoise, Vector3d::Zero(), Vector3d::Zero());
    Motion motion;
    for (const Sample& s : samples(200, seed)) {
      imu.integrate(s.force, s.rate, kDt);
      motion.move(s, kDt, kParts);
    }
    const auto d = imu.delta();
    EXPECT_LT(so3::log(d.q.conjugate() * Eigen::Quaterniond(motion.R).normalized()).norm(), 1e-8);
    EXPECT_LT((d.v - motion.v).norm(), 1e-8 * motion.v.norm());
    EXPECT_LT((d.p - motion.p).norm(), 1e-8 * motion.p.norm());
  }
}

// Sideways the force is worse known.
Vector3d force_density() {
  return {kNoise.accel_density, kNoise.sideways_density, kNoise.accel_density};
}

TEST(ImuPreintegration, CovarianceEqualsNumericPropagation) {
  ImuPreintegration imu(kNoise, Vector3d::Zero(), Vector3d::Zero());
  Motion motion;
  Matrix9d P = Matrix9d::Zero();
  for (const Sample& s : samples(100, 11)) {
    imu.integrate(s.force, s.rate, kDt);
    Motion next = motion;
    next.move(s, kDt, kParts);
    auto response = [&](const Vector9d& error, const Sample& sample) {
      Motion m = motion.off_by(error);
      m.move(sample, kDt, kParts);
      return next.to(m);
    };
    const Matrix9d F =
        numeric_jacobian(9, 1e-3, [&](const Vector9d& error) { return response(error, s); });
    const Eigen::Matrix<double, 9, 6> G = numeric_jacobian(6, 0.1, [&](const Vector6d& d) {
      return response(Vector9d::Zero(), {s.force + d.tail<3>(), s.rate + d.head<3>()});
    });
    Eigen::Matrix<double, 6, 1> q;
    q << Vector3d::Constant(kNoise.gyro_density), force_density();
    q = (q.cwiseAbs2() / kDt).eval();
    P = F * P * F.transpose() + G * q.asDiagonal() * G.transpose();
    motion = next;
  }
  const Eigen::Matrix<double, 9, 1> unit = P.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix9d off = unit.asDiagonal() * (P - imu.covariance()) * unit.asDiagonal();
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ImuPreintegration, BiasDerivativesEqualIntegratingAgain) {
  const auto truth = samples(100, 31);
  auto integrate = [&](const Vector3d& bg, const Vector3d& ba) {
    ImuPreintegration p(kNoise, bg, ba);
    for (const Sample& s : truth) p.integrate(s.force, s.rate, kDt);
    return p;
  };
  const Vector3d zero = Vector3d::Zero();
  const ImuPreintegration p = integrate(zero, zero);
  const auto moved = [&](const Vector3d& bg, const Vector3d& ba) {
    const auto d = integrate(bg, ba).delta();
    Vector9d e;
    e << so3::log(p.delta().q.conjugate() * d.q), d.v, d.p;
    return e;
  };
  const Eigen::MatrixXd by_bg =
      numeric_jacobian(3, 1e-4, [&](const Vector3d& b) { return moved(b, zero); });
  const Eigen::MatrixXd by_ba =
      numeric_jacobian(3, 1e-4, [&](const Vector3d& b) { return moved(zero, b); });
  EXPECT_LT((by_bg.topRows(3) - p.dq_dbg()).norm(), 1e-6 * p.dq_dbg().norm());
  EXPECT_LT((by_bg.middleRows(3, 3) - p.dv_dbg()).norm(), 1e-6 * p.dv_dbg().norm());
  EXPECT_LT((by_bg.bottomRows(3) - p.dp_dbg()).norm(), 1e-6 * p.dp_dbg().norm());
  EXPECT_LT((by_ba.middleRows(3, 3) - p.dv_dba()).norm(), 1e-6 * p.dv_dba().norm());
  EXPECT_LT((by_ba.bottomRows(3) - p.dp_dba()).norm(), 1e-6 * p.dp_dba().norm());
}

}  // namespace
}  // namespace gprodom
