// Marginalising must not lose information unnecessarily, and must not gain any that was not
// measured, with either solver. Both must find the same solution.
#include "estimation/fixed_lag_smoother.h"

#include <gtest/gtest.h>

#include <limits>

#include "estimation/batch.h"
#include "estimation/noisy_drive.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class FixedLagSmootherTest : public testing::TestWithParam<SolverKind> {};
INSTANTIATE_TEST_SUITE_P(Solvers, FixedLagSmootherTest,
                         testing::Values(SolverKind::kCeres, SolverKind::kChain),
                         [](const auto& solver) { return name_of(solver.param); });

StateVector known_start() {  // 1 mm, 1 mrad of yaw
  StateVector sigma;
  sigma << 0.01, 0.01, 1e-3, Vector3d::Constant(1e-3), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.03), 0.02;
  return sigma;
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

TEST_P(FixedLagSmootherTest, EqualsTheBatchOnALinearProblem) {
  Noise n(1);
  NavState first;
  const MarginalPrior prior = origin_prior(first, StateVector::Ones());
  FixedLagSmoother smoother(2.5, {3}, GetParam(), first, prior);
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
      tie(k - back, k,
          std::make_shared<OffsetFactor>(OffsetFactor::Vector7d::NullaryExpr([&] { return n(); })));
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

TEST_P(FixedLagSmootherTest, StatesThatAMeasurementIsStillToReferToStay) {
  NoisyDrive drive;
  FixedLagSmoother smoother = drive.smoother(2.0, {4}, GetParam(), StateVector::Constant(0.01));
  const auto extend = [&](int states, std::optional<TimeNs> since) {
    for (int k = 0; k < states; ++k) {
      drive.extend(smoother);
      ASSERT_TRUE(smoother.solve().usable);
      smoother.marginalise(since);
    }
  };
  extend(30, std::nullopt);
  const auto oldest = smoother.oldest_id();
  ASSERT_GT(oldest, 0);
  const TimeNs since = smoother.state(oldest).time;
  extend(20, since);
  EXPECT_EQ(smoother.oldest_id(), oldest);
  extend(1, smoother.newest().time);
  EXPECT_NEAR(to_seconds(smoother.newest().time - smoother.state(smoother.oldest_id()).time), 2.0,
              0.5);
}

TEST_P(FixedLagSmootherTest, PriorGainsNoInformationOnGlobalPositionAndYaw) {
  NoisyDrive drive;
  FixedLagSmoother smoother = drive.smoother(2.0, {4}, GetParam(), known_start());
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

// One row: its residual, its derivative by a coordinate of the later state, and minus that by the
// same of the earlier state if it is of their difference.
struct Row {
  double residual;
  int coordinate;
  double derivative;
  bool of_difference = false;
};
class RowFactor final : public Factor {
 public:
  using Of = Row (*)(const NavState& a, const NavState& b);
  explicit RowFactor(Of of) : of_(of) {}
  int dimension() const override { return 1; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override {
    const Row row = of_(a, b);
    r.setConstant(1, row.residual);
    if (!Ja) return;
    Jb->setZero(1, kStateDim);
    (*Jb)(0, row.coordinate) = row.derivative;
    *Ja = (row.of_difference ? -1.0 : 0.0) * *Jb;
  }

 private:
  Of of_;
};

// Of the wheel's scale alone. Its tangent overshoots far, so that only a damped step is accepted.
Row bent_row(const NavState& /*a*/, const NavState& b) {
  const double x = 500 * (b.wheel_scale - 1.1);
  return {1e3 * std::atan(x), row::kScale, 1e3 * 500 / (1 + x * x)};
}

// A measurement of the position in odom, which no sensor of the robot gives.
Row place_row(const NavState& /*a*/, const NavState& b) {
  return {b.p_odom.x() / 0.1, row::kP, 10.0};
}

StateVector loose_origin() {
  StateVector sigma;
  sigma << 0.01, 0.01, 0.1, Vector3d::Constant(3.0), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.03), 0.2;
  return sigma;
}

TEST_P(FixedLagSmootherTest, DampingOfTheLastStepAddsNoInformation) {
  for (const bool bent : {false, true}) {
    NoisyDrive drive;
    // The convergence limit is so large that the first accepted step is the last.
    FixedLagSmoother smoother = drive.smoother(10.0, {40, 1e12}, GetParam(), loose_origin());
    for (int k = 0; k < 5; ++k) drive.extend(smoother);
    if (bent) smoother.add_factor(3, 4, std::make_shared<RowFactor>(bent_row));
    const SolveSummary summary = smoother.solve();
    EXPECT_EQ(summary.accepted, 1);
    EXPECT_EQ(summary.steps > 1, bent);
    EXPECT_FALSE(summary.unfounded);
    EXPECT_GE(smoother.newest_covariance()(row::kTheta + 2, row::kTheta + 2), 0.99 * 0.01);
    EXPECT_GE(smoother.newest_covariance()(row::kP, row::kP), 0.99 * 9.0);
  }
}

TEST_P(FixedLagSmootherTest, InformationWithoutAMeasurementIsReported) {
  NoisyDrive drive;
  FixedLagSmoother smoother = drive.smoother(1.0, {4}, GetParam(), loose_origin());
  for (int k = 0; k < 60; ++k) {
    drive.extend(smoother);
    if (k == 50) smoother.add_factor(49, 50, std::make_shared<RowFactor>(place_row));
    const SolveSummary summary = smoother.solve();
    if (k < 55) {  // until the place is marginalised, and is in the prior
      EXPECT_EQ(summary.unfounded, k >= 50) << "state " << k;
    }
    smoother.marginalise();
  }
}

// A step with a large change of velocity and tilt must not add information on the heading.
TEST_P(FixedLagSmootherTest, PriorGainsNoInformationAfterMovingFar) {
  NoisyDrive drive;
  FixedLagSmoother smoother = drive.smoother(1.0, {4}, GetParam(), loose_origin());
  for (int k = 0; k < 30; ++k) {
    drive.extend(smoother);
    if (k == 15)  // a measurement so strong that the whole window follows it
      for (int back = 0; back < 4; ++back)
        smoother.add_factor(k - back - 1, k - back,
                            std::make_shared<StandstillFactor>(StandstillSigmas{1e-5, 1e-4, 2e-3}));
    EXPECT_FALSE(smoother.solve().unfounded) << "state " << k;
    smoother.marginalise();
  }
}

TEST_P(FixedLagSmootherTest, CovarianceEqualsTheDenseInverse) {
  NoisyDrive drive;
  StateVector sigma;
  sigma << Vector3d::Constant(1e-3), Vector3d::Constant(1e-3), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.03), 0.02;
  FixedLagSmoother kept = drive.smoother(1000.0, {20, 1e-9}, GetParam(), sigma);
  for (int k = 0; k < 12; ++k) drive.extend(kept);
  EXPECT_TRUE(kept.solve().usable);
  const StateMatrix covariance = kept.newest_covariance();

  // Marginalising all but the newest state by QR must give the same.
  const NavState newest = kept.newest();
  FixedLagSmoother same = drive.smoother(1e-3, {20, 1e-9}, GetParam(), sigma);
  NoisyDrive again;
  for (int k = 0; k < 12; ++k) again.extend(same);
  EXPECT_TRUE(same.solve().usable);
  same.marginalise();
  ASSERT_EQ(same.prior().states(), 1);
  const StateMatrix from_prior = (same.prior().A.transpose() * same.prior().A).inverse();
  EXPECT_LT(local(newest, same.newest()).norm(), 1e-9);
  const StateVector unit = covariance.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT((unit.asDiagonal() * (from_prior - covariance) * unit.asDiagonal()).norm(), 1e-3);
}

// Slip that the robust row outvotes, and a displacement over several states.
void disturb(FixedLagSmoother& smoother, int k) {
  const auto b = smoother.newest_id();
  if (k % 17 == 5) {
    WheelIncrement slipped(smoother.newest().gyro_bias);
    slipped.integrate(Vector3d(0, 0, 0.4), 0.2, 0.18);
    smoother.add_factor(b - 1, b,
                        std::make_shared<WheelFactor>(slipped, Vector3d(0.1, 0, 0),
                                                      Vector3d(4e-6, 1e-6, 1e-6), 1.5));
  }
  DisplacementFactor::Measurement measured;
  measured.distance_m = 0.66;
  measured.sigma_m = 0.02;
  measured.robust_threshold = 2.0;
  if (k % 3 == 0 && b - 6 >= smoother.oldest_id())
    smoother.add_factor(b - 6, b, std::make_shared<DisplacementFactor>(measured, Vector3d::Zero()));
}

TEST(WindowSolvers, BothFindTheSameSolution) {
  NoisyDrive drive, again;
  FixedLagSmoother by_ceres = drive.smoother(2.0, {4}, SolverKind::kCeres, known_start());
  FixedLagSmoother by_chain = drive.smoother(2.0, {4}, SolverKind::kChain, known_start());
  for (int k = 0; k < 300; ++k) {
    drive.extend(by_ceres);
    again.extend(by_chain);
    disturb(by_ceres, k);
    disturb(by_chain, k);
    const SolveSummary ceres = by_ceres.solve(), chain = by_chain.solve();
    ASSERT_TRUE(ceres.usable && chain.usable) << k;
    EXPECT_EQ(ceres.accepted, chain.accepted) << k;
    ASSERT_LT(local(by_ceres.newest(), by_chain.newest()).norm(), 1e-6) << k;
    const StateMatrix& P = by_ceres.newest_covariance();
    const StateVector unit = P.diagonal().cwiseSqrt().cwiseInverse();
    const StateMatrix difference = P - by_chain.newest_covariance();
    ASSERT_LT((unit.asDiagonal() * difference * unit.asDiagonal()).norm(), 1e-6) << k;
    by_ceres.marginalise();
    by_chain.marginalise();
  }
}

// Ceres keeps blocks in sets that are ordered by address. This must not affect the result.
TEST(WindowSolvers, RepeatedSolvesAreBitwiseEqual) {
  NoisyDrive drive, again;
  FixedLagSmoother first = drive.smoother(1.0, {4}, SolverKind::kCeres, known_start());
  FixedLagSmoother second = drive.smoother(1.0, {4}, SolverKind::kCeres, known_start());
  std::vector<std::unique_ptr<char[]>> elsewhere;
  for (int k = 0; k < 100; ++k) {
    drive.extend(first);
    disturb(first, k);
    first.solve();
    first.marginalise();
  }
  for (int k = 0; k < 100; ++k) {
    elsewhere.push_back(std::make_unique<char[]>(100 + 977 * (k % 7)));  // other addresses
    again.extend(second);
    disturb(second, k);
    second.solve();
    second.marginalise();
  }
  EXPECT_EQ(local(first.newest(), second.newest()), StateVector::Zero());
  EXPECT_EQ(first.newest_covariance(), second.newest_covariance());
}

Row broken_row(const NavState& /*a*/, const NavState& /*b*/) {
  return {std::numeric_limits<double>::quiet_NaN(), row::kScale, 0.0};
}

TEST_P(FixedLagSmootherTest, FailedSolveDoesNotChangeTheStates) {
  NoisyDrive drive;
  FixedLagSmoother smoother = drive.smoother(2.0, {4}, GetParam(), known_start());
  for (int k = 0; k < 5; ++k) drive.extend(smoother);
  EXPECT_TRUE(smoother.solve().usable);
  drive.extend(smoother);
  const NavState before = smoother.newest();
  const StateMatrix covariance = smoother.newest_covariance();
  smoother.add_factor(4, 5, std::make_shared<RowFactor>(broken_row));
  EXPECT_FALSE(smoother.solve().usable);
  EXPECT_EQ(local(before, smoother.newest()), StateVector::Zero());
  EXPECT_EQ(smoother.newest_covariance(), covariance);
}

// atan of the scale's change, far from its root: a full step goes further away each time.
Row overshooting_row(const NavState& a, const NavState& b) {
  const double x = 3.0 + 10.0 * (b.wheel_scale - a.wheel_scale);
  return {1e3 * std::atan(x), row::kScale, 1e4 / (1 + x * x), true};
}

TEST_P(FixedLagSmootherTest, StepThatRaisesTheCostIsDamped) {
  NavState first, second;
  second.time = 1'000'000'000;
  FixedLagSmoother smoother(10.0, {100}, GetParam(), first,
                            origin_prior(first, StateVector::Constant(1.0)));
  smoother.add_state(second);
  smoother.add_factor(0, 1, std::make_shared<StandstillFactor>(StandstillSigmas{1, 1, 1}));
  smoother.add_factor(0, 1, std::make_shared<RandomWalkFactor>(1.0, 1.0, 100.0));
  smoother.add_factor(0, 1, std::make_shared<RowFactor>(overshooting_row));
  const SolveSummary summary = smoother.solve();
  EXPECT_TRUE(summary.usable);
  EXPECT_LT(summary.accepted, summary.steps);
  EXPECT_NEAR(smoother.newest().wheel_scale - smoother.state(0).wheel_scale, -0.3, 1e-3);
}

}  // namespace
}  // namespace gprodom
