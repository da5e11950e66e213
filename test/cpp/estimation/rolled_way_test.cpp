// What the count of an encoder tells of the way through a gap of its messages.
#include "estimation/rolled_way.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "estimation/batch.h"
#include "estimation/noisy_drive.h"
#include "estimation/predict.h"
#include "estimation/revised_state.h"
#include "support/derivative.h"

namespace gprodom {
namespace {

const Eigen::Vector3d kContact(0.0, -0.2, 0.05);

std::vector<NavState> on_a_circle(double speed, double turn, int count) {
  std::vector<NavState> states(count);
  for (int i = 0; i < count; ++i) {
    const double t = 0.2 * i, angle = turn * t, radius = speed / turn;
    NavState& x = states[i];
    x.time = from_seconds(t);
    x.q_odom_body = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
    x.p_odom = {radius * std::sin(angle), radius * (1 - std::cos(angle)), 0.3};
    x.v_odom = x.q_odom_body * Eigen::Vector3d(speed, 0, 0);
    x.wheel_scale = 1.02;
  }
  return states;
}

// The contact point has a speed of its own: that of the body, and what the turn adds.
TEST(RolledWay, IsTheArcOfTheContactPointInTheWheelsUnits) {
  const auto states = on_a_circle(0.6, 0.8, 51);
  const double arc = (0.6 - 0.8 * kContact.y()) * 10.0;
  EXPECT_NEAR(rolled_way(states.data(), states.size(), kContact).reported_m, 1.02 * arc, 1e-3);
}

TEST(RolledWay, Derivatives) {
  auto states = on_a_circle(0.6, 0.8, 6);
  const RolledWay way = rolled_way(states.data(), states.size(), kContact);
  for (std::size_t i = 0; i < states.size(); ++i) {
    const NavState x = states[i];
    const Eigen::MatrixXd numeric = numeric_jacobian(kStateDim, 1e-4, [&](const StateVector& d) {
      states[i] = retract(x, d);
      return Eigen::VectorXd::Constant(
          1, rolled_way(states.data(), states.size(), kContact).reported_m);
    });
    states[i] = x;
    // The bend's correction of the chord (0.4 %) is not differentiated.
    EXPECT_LT((numeric.transpose() - way.d[i]).cwiseAbs().maxCoeff(), 0.02) << i;
  }
}

// A window over a way on which the wheel is silent.
FixedLagSmoother without_wheel(const std::vector<NavState>& truth, SolverKind kind, Noise& noise) {
  FixedLagSmoother smoother(100.0, {}, kind, truth[0],
                            origin_prior(truth[0], StateVector::Constant(1e-4)));
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const NavState last = smoother.newest();
    ImuPreintegration imu({1e-4, 0.05}, last.gyro_bias, last.accel_bias);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d force(0, 0.6 * 0.3, kStandardGravity), rate(0, 0, 0.3);
      imu.integrate(force + noise.vector(0.05 / std::sqrt(0.01)),
                    rate + noise.vector(1e-4 / std::sqrt(0.01)), 0.01);
    }
    NavState next = propagate(last, imu, kStandardGravity);
    next.time = truth[i].time;
    const auto b = smoother.add_state(next), a = b - 1;
    smoother.add_factor(a, b,
                        std::make_shared<ImuFactor>(imu, Eigen::Vector3d(0, 0, -kStandardGravity)));
    smoother.add_factor(a, b, std::make_shared<RandomWalkFactor>(1e-6, 1e-5, 1e-6));
    // It moves neither sideways nor upwards.
    WheelIncrement increment(last.gyro_bias);
    increment.integrate({0, 0, 0.3}, 0.2, 0.12);
    smoother.add_factor(
        a, b,
        std::make_shared<WheelFactor>(increment, kContact, Eigen::Vector3d(1e4, 1e-6, 1e-6), 0.0));
  }
  return smoother;
}

// The count of ten seconds is told afterwards. Errors are as the covariance says, and the way no
// longer drifts. Every other window is that of the other solver.
TEST(RolledWay, CountCorrectsTheWindowAsItsCovarianceSays) {
  const auto truth = on_a_circle(0.6, 0.3, 51);
  double nees = 0.0, square = 0.0, square_before = 0.0;
  constexpr int kRuns = 100;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    Noise random(seed);
    FixedLagSmoother smoother =
        without_wheel(truth, seed % 2 == 0 ? SolverKind::kChain : SolverKind::kCeres, random);
    ASSERT_TRUE(smoother.solve().usable);
    const EstimatedWay way = smoother.way_between(0, smoother.newest_id(), kContact);
    CountedWay told{truth.front().time, truth.back().time, 0.0, 1e6};
    told.counted_m = 1.02 * (0.6 - 0.3 * kContact.y()) * 10.0 + random(0.005);
    const CarriedState revised =
        with_counted_way({smoother.newest(), smoother.newest_covariance()}, way, told.counted_m,
                         weight_of(way, told, 0.005 * 0.005));
    const Eigen::Vector2d place = local(revised.state, truth.back()).segment<2>(row::kP);
    nees += place.dot(revised.covariance.block<2, 2>(row::kP, row::kP).inverse() * place) / kRuns;
    square += (revised.state.p_odom - truth.back().p_odom).squaredNorm();
    square_before += (smoother.newest().p_odom - truth.back().p_odom).squaredNorm();
  }
  EXPECT_GT(nees, 1.5);
  EXPECT_LT(nees, 2.6);
  EXPECT_LT(square, 0.3 * square_before);
}

// The solution over all data takes it as it is.
TEST(RolledWay, CountStretchesTheBatch) {
  const auto states = on_a_circle(0.6, 0.8, 11);
  Batch batch(states[0], origin_prior(states[0], StateVector::Constant(1e-4)));
  for (std::size_t i = 1; i < states.size(); ++i) {
    batch.add_state(states[i]);
    WheelIncrement increment(Eigen::Vector3d::Zero());
    increment.integrate({0, 0, 0.8}, 0.2, 1.02 * 0.2 * (0.6 - 0.8 * kContact.y()));
    batch.add_factor(
        i - 1, i,
        std::make_shared<WheelFactor>(increment, kContact, Eigen::Vector3d(0.01, 1e-8, 1e-8), 0.0));
    batch.add_factor(i - 1, i, std::make_shared<RandomWalkFactor>(1e-6, 1e-5, 1e-8));
  }
  const double counted = 1.1 * rolled_way(states.data(), states.size(), kContact).reported_m;
  batch.add_way({0, states.size() - 1, kContact, counted, 1e-3});
  const auto solved = batch.solve({});
  EXPECT_NEAR(rolled_way(solved.data(), solved.size(), kContact).reported_m, counted, 2e-3);
}

TEST(RolledWay, WeightFollowsWhatTheCountMayBe) {
  EstimatedWay way;
  way.reported_m = 10.0;
  way.variance = 0.04;
  const auto weight = [&](double counted_m, double restarted_m, double slips) {
    return weight_of(way, {0, from_seconds(10.0), counted_m, restarted_m, slips, 0.5}, 0.01);
  };
  // Long after its start, far from where a count from 0 would be: in full.
  EXPECT_NEAR(weight(10.3, 530.0, 0.0).mean, 20.0, 1e-9);
  EXPECT_NEAR(weight(10.3, 530.0, 0.0).sigma, 0.0, 1e-9);
  // A wheel that may have slipped: a count that fits still has most of it, one that is far off
  // that of a slip.
  EXPECT_GT(weight(10.3, 530.0, 0.3).mean, 18.0);
  EXPECT_LT(weight(14.0, 530.0, 0.3).mean, 0.1);
  // It was off, or began at 0 in the gap, after 20 m.
  EXPECT_EQ(weight(0.0, 520.0, 0.0).mean, 0.0);
  EXPECT_LT(weight(-14.0, 6.0, 0.0).mean, 0.01);
  // Near its start a right count is small, too.
  EXPECT_GT(weight(10.3, 11.0, 0.0).mean, 19.0);
}

}  // namespace
}  // namespace gprodom
