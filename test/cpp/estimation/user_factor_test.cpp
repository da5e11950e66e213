// A user's own measurement in the window: its effect, what remains of it after the window has moved
// on, and which factors are refused.
#include "gprodom/user_factor.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/driven_intervals.h"

namespace gprodom {
namespace {

constexpr double kInterval = kStateInterval, kRadius = kSpeed / kTurn;  // s, m
const Eigen::Vector3d kBeacon(3.0, 8.0, 1.0);                           // m, in odom

Eigen::Vector3d place(double seconds) {
  return kRadius * Eigen::Vector3d(std::sin(kTurn * seconds), 1 - std::cos(kTurn * seconds), 0);
}

// The wheel's scale is not known.
StateInput interval(double from, Noise& noise) {
  StateInput input = gprodom::interval(from, {kSpeed, kTurn}, noise);
  for (MotionStep& step : input.steps) step.wheel_m *= 1.05;
  return input;
}

StateEstimator estimator(SolverKind solver) {
  Config config;
  config.smoother.solver = solver;
  config.wheel.scale_sigma = 0.1;
  InitialState initial;
  initial.state.v_odom.x() = kSpeed;
  initial.noise = {1.6e-4, 6e-4};
  StateVector sigma = StateVector::Constant(1e-3);
  sigma.segment<3>(row::kV).setConstant(0.1);
  sigma.segment<3>(row::kBa).setConstant(0.1);
  sigma[row::kScale] = 0.1;
  initial.prior = gaussian_prior(initial.state, sigma.cwiseAbs2().asDiagonal());
  return {config, initial};
}

struct Range {
  double measured_m, sigma_m;
  template <typename T>
  bool operator()(const T* p, T* r) const {
    const Eigen::Matrix<T, 3, 1> d =
        Eigen::Map<const Eigen::Matrix<T, 3, 1>>(p) - kBeacon.cast<T>();
    r[0] = (d.norm() - T(measured_m)) / T(sigma_m);
    return true;
  }
};

UserFactor range_at(double seconds, double error_m = 0.0) {
  const double measured_m = (place(seconds) - kBeacon).norm() + error_m;
  return {"beacon",
          {from_seconds(seconds)},
          {{0, StatePart::kPosition}},
          std::make_shared<ceres::AutoDiffCostFunction<Range, 1, 3>>(new Range{measured_m, 0.01}),
          std::make_shared<ceres::CauchyLoss>(2.0)};
}

class UserFactorTest : public testing::TestWithParam<SolverKind> {};
INSTANTIATE_TEST_SUITE_P(Solvers, UserFactorTest,
                         testing::Values(SolverKind::kCeres, SolverKind::kChain),
                         [](const auto& solver) { return name_of(solver.param); });

// Ranges over twenty seconds determine the wheel's scale. Their information is still there when all
// of them have left the window.
TEST_P(UserFactorTest, InformationStaysAfterTheFactorLeavesTheWindow) {
  StateEstimator with = estimator(GetParam()), without = estimator(GetParam());
  Noise random(1), same(1), error(2);
  StateResult result, blind;
  for (int k = 0; k < 200; ++k) {
    const double from = k * kInterval;
    StateInput input = interval(from, random);
    // In the middle of an interval, and now and then one that is wrong by a metre.
    if (k < 100) input.factors = {range_at(from + 0.07, k % 10 == 3 ? 1.0 : error(0.01))};
    result = with.add(input);
    blind = without.add(interval(from, same));
    ASSERT_TRUE(result.solve.usable && blind.solve.usable) << k;
    ASSERT_FALSE(result.solve.unfounded) << k;  // the range does measure the place
    EXPECT_EQ(result.factors_used, k < 100)
        << (result.refused.empty() ? "" : result.refused[0].reason);
  }
  const Eigen::Vector3d truth = place(200 * kInterval);
  EXPECT_LT((result.state.p_odom - truth).head<2>().norm(), 0.03);
  EXPECT_GT((blind.state.p_odom - truth).head<2>().norm(), 0.2);
  EXPECT_NEAR(result.state.wheel_scale, 1.05, 2e-3);
  EXPECT_LT(3 * result.covariance(row::kScale, row::kScale),
            blind.covariance(row::kScale, row::kScale));
}

TEST(UserFactor, BothSolversFindTheSameSolution) {
  StateEstimator by_ceres = estimator(SolverKind::kCeres), by_chain = estimator(SolverKind::kChain);
  Noise random(1), same(1);
  for (int k = 0; k < 60; ++k) {
    StateInput input = interval(k * kInterval, random);
    input.factors = {range_at(k * kInterval + 0.13, 0.05 * (k % 3 - 1))};
    StateInput other = interval(k * kInterval, same);
    other.factors = input.factors;
    const StateResult ceres = by_ceres.add(input), chain = by_chain.add(other);
    ASSERT_LT(local(ceres.state, chain.state).norm(), 1e-6) << k;
  }
}

// Known places of the robot at both ends of a second, from a cost function of two moments.
struct Shift {
  Eigen::Vector3d measured_m;
  template <typename T>
  bool operator()(const T* p0, const T* p1, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = (p1[i] - p0[i] - T(measured_m[i])) / T(1e-3);
    return true;
  }
};

TEST_P(UserFactorTest, MayConnectTwoMoments) {
  StateEstimator with = estimator(GetParam());
  Noise random(1);
  StateResult result;
  for (int k = 0; k < 100; ++k) {
    const double from = k * kInterval;
    StateInput input = interval(from, random);
    if (k >= 5) {
      const double begin = from - 0.95, end = from + 0.1;
      const auto cost = std::make_shared<ceres::AutoDiffCostFunction<Shift, 3, 3, 3>>(
          new Shift{place(end) - place(begin)});
      input.factors = {{"shift",
                        {from_seconds(begin), from_seconds(end)},
                        {{0, StatePart::kPosition}, {1, StatePart::kPosition}},
                        cost,
                        nullptr}};
    }
    result = with.add(input);
    ASSERT_TRUE(result.refused.empty()) << result.refused[0].reason;
  }
  EXPECT_NEAR(result.state.wheel_scale, 1.05, 2e-3);
  EXPECT_LT((result.state.p_odom - place(20.0)).head<2>().norm(), 0.02);
}

TEST(UserFactor, IsRefusedWithAReason) {
  StateEstimator window = estimator(SolverKind::kCeres);
  Noise random(1);
  const auto refusal = [&](int k, const UserFactor& factor) {
    StateInput input = interval(k * kInterval, random);
    input.factors = {factor};
    const StateResult result = window.add(input);
    EXPECT_TRUE(result.solve.usable);
    return result.refused.empty() ? std::string() : result.refused[0].reason;
  };
  for (int k = 0; k < 40; ++k) EXPECT_EQ(refusal(k, range_at(k * kInterval + 0.1)), "");
  EXPECT_EQ(refusal(40, range_at(4.0)), "");  // late, but in the lag of 5 s
  EXPECT_EQ(refusal(41, range_at(2.0)), "older than the window (smoother.lag)");
  EXPECT_EQ(refusal(42, range_at(60.0)), "newer than the newest state");

  struct Case {
    void (*spoil)(UserFactor&);
    const char* reason;
  };
  int k = 43;
  for (const auto& [spoil, reason] :
       {Case{[](UserFactor& f) { f.blocks[0].part = StatePart::kAttitude; },
             "block 0: the part has 4 values, the cost function expects 3"},
        Case{[](UserFactor& f) { f.blocks[0].moment = 1; }, "block 0: no such moment"},
        Case{[](UserFactor& f) { f.blocks.clear(); },
             "expected a part of the state for each parameter block of the cost function"},
        Case{[](UserFactor& f) {
               f.times = {from_seconds(8.0), from_seconds(7.0)};
             },
             "the later moment is first"},
        Case{[](UserFactor& f) { f.cost = nullptr; }, "no cost function"}}) {
    UserFactor factor = range_at(8.0);
    spoil(factor);
    EXPECT_EQ(refusal(k++, factor), reason);
  }
  EXPECT_EQ(refusal(48, range_at(8.0, std::nan(""))), "the cost function fails at the estimate");
}

}  // namespace
}  // namespace gprodom
