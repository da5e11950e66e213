// Marginalising must lose nothing that it does not have to, and gain nothing that was not measured.
#include "estimation/fixed_lag_smoother.h"

#include <gtest/gtest.h>

#include <random>

#include "estimation/batch.h"

namespace gprodom {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

MarginalPrior origin_prior(const NavState& x, const StateVector& sigma) {
  MarginalPrior prior;
  prior.x0 = {x};
  prior.A = sigma.cwiseInverse().asDiagonal();
  prior.b = StateVector::Zero();
  return prior;
}

// Differences of biases and scale, measured: the error's rows in which the chart is linear.
class OffsetFactor final : public Factor {
 public:
  using Vector7d = Eigen::Matrix<double, 7, 1>;
  explicit OffsetFactor(const Vector7d& measured) : measured_(measured) {}
  int dimension() const override { return 7; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override {
    r = local(a, b).tail<7>() - measured_;
    if (!Ja) return;
    Jb->setZero(7, kStateDim);
    Jb->rightCols<7>().setIdentity();
    *Ja = -*Jb;
  }

 private:
  Vector7d measured_;
};

TEST(FixedLagSmoother, EqualsTheBatchOnALinearProblem) {
  std::mt19937 engine(1);
  std::normal_distribution<double> n;
  NavState first;
  const MarginalPrior prior = origin_prior(first, StateVector::Ones());
  FixedLagSmoother smoother({2.5, 3}, first, prior);
  Batch batch(first, prior);
  auto tie = [&](std::int64_t a, std::int64_t b, std::shared_ptr<const Factor> factor) {
    ASSERT_TRUE(smoother.add_factor(a, b, factor));
    batch.add_factor(static_cast<size_t>(a), static_cast<size_t>(b), factor);
  };
  for (std::int64_t k = 1; k <= 20; ++k) {
    NavState x;
    x.time = k * 1'000'000'000;
    smoother.add_state(x);
    batch.add_state(x);
    // One between neighbours and one over two intervals, in disagreement.
    for (std::int64_t back = 1; back <= std::min<std::int64_t>(2, k); ++back)
      tie(k - back, k, std::make_shared<OffsetFactor>(OffsetFactor::Vector7d::NullaryExpr([&] {
            return n(engine);
          })));
    tie(k - 1, k, std::make_shared<RandomWalkFactor>(0.5, 2.0, 1.0));
    tie(k - 1, k, std::make_shared<StandstillFactor>(StandstillSigmas{1, 1, 1}));
    const SolveSummary summary = smoother.solve();
    EXPECT_TRUE(summary.usable);
    EXPECT_EQ(summary.steps, summary.accepted);
    smoother.marginalise();
  }
  EXPECT_GT(smoother.oldest_id(), 10);
  EXPECT_LT(local(batch.solve({}).back(), smoother.newest()).norm(), 1e-9);
}

// A noisy drive round a circle: IMU and wheel factors between states.
struct Drive {
  std::mt19937 engine{7};
  std::normal_distribution<double> n;
  const double speed = 0.6, turn = 0.4, dt = 0.005;
  const Vector3d gravity{0, 0, -9.80665};
  const ImuNoise noise{1.6e-4, 5.9e-4};

  Vector3d white(double density) {
    return density / std::sqrt(dt) * Vector3d(n(engine), n(engine), n(engine));
  }

  NavState start() const {
    NavState x;
    x.v_odom = Vector3d(speed, 0, 0);
    return x;
  }

  void extend(FixedLagSmoother& smoother) {
    const NavState last = smoother.newest();
    ImuPreintegration imu(noise, last.gyro_bias, last.accel_bias);
    WheelIncrement wheel(last.gyro_bias);
    for (int i = 0; i < 40; ++i) {
      const Vector3d rate = Vector3d(0, 0, turn) + white(noise.gyro_density);
      imu.integrate(Vector3d(0, speed * turn, 0) - gravity + white(noise.accel_density), rate, dt);
      wheel.integrate(rate, dt, speed * dt * (1 + 0.02 * n(engine)));
    }
    NavState next = last;
    const auto d = imu.delta();
    const double T = imu.duration();
    next.time += from_seconds(T);
    next.p_odom += last.v_odom * T + 0.5 * gravity * T * T + last.q_odom_body * d.p;
    next.v_odom += gravity * T + last.q_odom_body * d.v;
    next.q_odom_body = last.q_odom_body * d.q;
    const auto b = smoother.add_state(next), a = b - 1;
    smoother.add_factor(a, b, std::make_shared<ImuFactor>(imu, gravity));
    smoother.add_factor(a, b, std::make_shared<RandomWalkFactor>(1e-5, 1e-4, 1e-6));
    smoother.add_factor(
        a, b,
        std::make_shared<WheelFactor>(wheel, Vector3d(0.1, 0, 0), Vector3d(4e-6, 1e-6, 1e-6), 1.5));
  }
};

TEST(FixedLagSmoother, PriorGainsNothingOnGlobalPositionAndYaw) {
  Drive drive;
  StateVector sigma;  // the origin's prior: 1 mm, 1 mrad of yaw
  sigma << 0.01, 0.01, 1e-3, Vector3d::Constant(1e-3), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.03), 0.02;
  FixedLagSmoother smoother({2.0, 4}, drive.start(), origin_prior(drive.start(), sigma));
  int steps = 0, accepted = 0;
  for (int k = 0; k < 400; ++k) {
    drive.extend(smoother);
    const SolveSummary summary = smoother.solve();
    steps += summary.steps;
    accepted += summary.accepted;
    smoother.marginalise();
  }
  EXPECT_GE(accepted, 0.999 * steps);

  const MarginalPrior& prior = smoother.prior();
  const int n = prior.states();
  MatrixXd global = MatrixXd::Zero(n * kStateDim, 4);  // shift, and turn about gravity
  for (int i = 0; i < n; ++i) {
    global.block<3, 3>(i * kStateDim + row::kP, 0).setIdentity();
    global(i * kStateDim + row::kTheta + 2, 3) = 1;
  }
  const Eigen::Vector4d information = (prior.A * global).colwise().squaredNorm();
  for (int k = 0; k < 4; ++k) EXPECT_LE(information[k], 1e6 * (1 + 1e-6)) << "direction " << k;
  EXPECT_GT(information.minCoeff(), 1.0);  // and not all of the origin's is lost
}

// Of the wheel's scale alone. Its tangent overshoots far, so that only a damped step is accepted.
class BentFactor final : public Factor {
 public:
  int dimension() const override { return 1; }
  void evaluate(const NavState&, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override {
    const double x = 500 * (b.wheel_scale - 1.1);
    r.resize(1);
    r[0] = 1e3 * std::atan(x);
    if (!Ja) return;
    Ja->setZero(1, kStateDim);
    Jb->setZero(1, kStateDim);
    (*Jb)(0, row::kScale) = 1e3 * 500 / (1 + x * x);
  }
};

// What no sensor here measures: where the robot is in odom.
class PlaceFactor final : public Factor {
 public:
  int dimension() const override { return 1; }
  void evaluate(const NavState&, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override {
    r.resize(1);
    r[0] = b.p_odom.x() / 0.1;
    if (!Ja) return;
    Ja->setZero(1, kStateDim);
    Jb->setZero(1, kStateDim);
    Jb->row(0).segment<3>(row::kP).setUnit(3, 0);
    Jb->row(0) /= 0.1;
  }
};

StateVector loose_origin() {
  StateVector sigma;
  sigma << 0.01, 0.01, 0.1, Vector3d::Constant(3.0), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.03), 0.2;
  return sigma;
}

TEST(FixedLagSmoother, DampingOfTheLastStepIsNoKnowledge) {
  for (const bool bent : {false, true}) {
    Drive drive;
    // So early is it content that the first step accepted is the last.
    const SmootherOptions options{10.0, 40, 1e12};
    FixedLagSmoother smoother(options, drive.start(), origin_prior(drive.start(), loose_origin()));
    for (int k = 0; k < 5; ++k) drive.extend(smoother);
    if (bent) smoother.add_factor(3, 4, std::make_shared<BentFactor>());
    const SolveSummary summary = smoother.solve();
    EXPECT_EQ(summary.accepted, 1);
    EXPECT_EQ(summary.steps > 1, bent);
    EXPECT_FALSE(summary.unfounded);
    EXPECT_GE(smoother.newest_covariance()(row::kTheta + 2, row::kTheta + 2), 0.99 * 0.01);
    EXPECT_GE(smoother.newest_covariance()(row::kP, row::kP), 0.99 * 9.0);
  }
}

TEST(FixedLagSmoother, KnowledgeThatNothingMeasuredIsToldAsAFault) {
  Drive drive;
  FixedLagSmoother smoother({1.0, 4}, drive.start(), origin_prior(drive.start(), loose_origin()));
  for (int k = 0; k < 60; ++k) {
    drive.extend(smoother);
    if (k == 50) smoother.add_factor(49, 50, std::make_shared<PlaceFactor>());
    const SolveSummary summary = smoother.solve();
    if (k < 55) {  // until the place is marginalised, and is in the prior
      EXPECT_EQ(summary.unfounded, k >= 50) << "state " << k;
    }
    smoother.marginalise();
  }
}

// A step that moves velocity and tilt by much does not make the heading known.
TEST(FixedLagSmoother, PriorThatHasMovedFarGainsNothing) {
  Drive drive;
  NavState start = drive.start();
  FixedLagSmoother smoother({1.0, 4}, start, origin_prior(start, loose_origin()));
  for (int k = 0; k < 30; ++k) {
    drive.extend(smoother);
    if (k == 15)  // a word that the whole window gives way to
      for (int back = 0; back < 4; ++back)
        smoother.add_factor(k - back - 1, k - back,
                            std::make_shared<StandstillFactor>(StandstillSigmas{1e-5, 1e-4, 2e-3}));
    EXPECT_FALSE(smoother.solve().unfounded) << "state " << k;
    smoother.marginalise();
  }
}

TEST(FixedLagSmoother, CovarianceEqualsTheDenseInverse) {
  Drive drive;
  StateVector sigma;
  sigma << Vector3d::Constant(1e-3), Vector3d::Constant(1e-3), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.03), 0.02;
  const MarginalPrior origin = origin_prior(drive.start(), sigma);
  FixedLagSmoother kept({1000.0, 20, 1e-9}, drive.start(), origin);
  for (int k = 0; k < 12; ++k) drive.extend(kept);
  EXPECT_TRUE(kept.solve().usable);
  const StateMatrix covariance = kept.newest_covariance();

  // Marginalising all but the newest by QR must say the same.
  const NavState newest = kept.newest();
  FixedLagSmoother same({1e-3, 20, 1e-9}, drive.start(), origin);
  Drive again;
  for (int k = 0; k < 12; ++k) again.extend(same);
  EXPECT_TRUE(same.solve().usable);
  same.marginalise();
  ASSERT_EQ(same.prior().states(), 1);
  const StateMatrix from_prior = (same.prior().A.transpose() * same.prior().A).inverse();
  EXPECT_LT(local(newest, same.newest()).norm(), 1e-9);
  const StateVector unit = covariance.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT((unit.asDiagonal() * (from_prior - covariance) * unit.asDiagonal()).norm(), 1e-3);
}

}  // namespace
}  // namespace gprodom
