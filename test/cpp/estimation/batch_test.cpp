#include "estimation/batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "estimation/noisy_drive.h"
#include "estimation/predict.h"
#include "estimation/revised_state.h"
#include "estimation/rolled_way.h"
#include "support/derivative.h"

namespace gprodom {
namespace {

// Tells of each slip, and each step of the scale, that it was given.
class Listener final : public Factor {
 public:
  explicit Listener(std::vector<double>& told) : told_(told) {}
  int dimension() const override { return 0; }
  void evaluate(const NavState& /*a*/, const NavState& /*b*/, Residual& /*r*/, Jacobian* /*Ja*/,
                Jacobian* /*Jb*/) const override {}
  std::shared_ptr<const Factor> with_slip(double l) const override {
    told_.push_back(l);
    return nullptr;
  }
  std::shared_ptr<const Factor> with_scale_step(double sigma) const override {
    told_.push_back(sigma);
    return nullptr;
  }

 private:
  std::vector<double>& told_;
};

// Eleven hours of states. A pass over all links for each state would take a minute.
TEST(Batch, SlipsReachTheirStatesInOnePass) {
  constexpr std::size_t kStates = 200'000;
  Batch batch(NavState(), origin_prior(NavState(), StateVector::Ones()));
  std::vector<double> told;
  const auto listener = std::make_shared<Listener>(told);
  for (std::size_t i = 1; i < kStates; ++i) {
    batch.add_state(NavState());
    batch.add_factor(i - 1, i, listener);
  }
  std::vector<std::optional<double>> slips(kStates);
  for (std::size_t i = 0; i + 1 < kStates; ++i)
    if (i % 3 != 0) slips[i] = static_cast<double>(i);
  batch.set_slips(slips);
  ASSERT_EQ(told.size(), (kStates - 1) * 2 / 3);
  std::size_t k = 0;
  for (const std::optional<double>& slip : slips) {
    if (slip) {
      ASSERT_EQ(told[k++], *slip);
    }
  }
}

// A second at one place, which fixes are to tell.
Batch standing() {
  Batch batch(NavState(), origin_prior(NavState(), StateVector::Constant(1e-3)));
  NavState second;
  second.time = from_seconds(1.0);
  batch.add_state(second);
  batch.add_factor(0, 1, std::make_shared<StandstillFactor>(StandstillSigmas{1e-6, 1e-6, 1e-6}));
  batch.add_factor(0, 1, std::make_shared<RandomWalkFactor>(1e-6, 1e-6, 1e-6));
  batch.free_place();
  return batch;
}

// Fixes at one place whose errors last: by the dense covariance C of the fixes, the best place is
// 1^T C^-1 z / 1^T C^-1 1 in each axis.
TEST(Batch, ErrorsOfFixesLast) {
  constexpr double kSigma = 0.3, kWhite = 0.2;
  const std::vector<double> kept = {0.0, 0.99, 0.6, 0.95, 0.2, 0.9};  // with the one before
  Batch batch = standing();
  const auto n = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixX2d z = Eigen::MatrixX2d::Random(n, 2);
  Eigen::MatrixXd C = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    double lasting = 1.0 - kWhite;
    for (Eigen::Index k = i; k > 0; --k) {
      lasting *= kept[static_cast<std::size_t>(k)];
      C(i, k - 1) = C(k - 1, i) = lasting;
    }
    const FixFactor place(z.row(i).transpose(), kSigma * kSigma * Eigen::Matrix2d::Identity(),
                          Eigen::Vector3d::Zero(), 0.5, 1.0);
    std::optional<std::size_t> before;
    if (i > 0) before = static_cast<std::size_t>(i - 1);
    batch.add_fix({0, 1, place, kWhite, before, kept[static_cast<std::size_t>(i)]});
  }
  const Eigen::VectorXd weight = C.inverse() * Eigen::VectorXd::Ones(n);
  const Eigen::Vector2d best = z.transpose() * weight / weight.sum();
  EXPECT_GT((z.colwise().mean().transpose() - best).norm(), 0.02) << "not a case of its own";
  EXPECT_TRUE(batch.solve({}).front().p_odom.head<2>().isApprox(best, 1e-4));
}

TEST(Batch, SurveyedFixesAreWhite) {
  Batch batch = standing();
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 0)})
    batch.add_fix(
        {0, 1, FixFactor(p, Eigen::Matrix2d::Identity(), Eigen::Vector3d::Zero(), 0.5, 1.0)});
  const NavState solved = batch.solve({}).front();
  EXPECT_NEAR(solved.p_odom.x(), 2.0, 1e-4);
  EXPECT_NEAR(solved.p_odom.y(), 1.0, 1e-4);
  const FixFactor place({0, 0}, Eigen::Matrix2d::Identity(), Eigen::Vector3d::Zero(), 0.5, 1.0);
  EXPECT_THROW(batch.add_fix({0, 1, place, 0.5, 2, 0.5}), std::invalid_argument);
  EXPECT_THROW(batch.add_fix({0, 2, place}), std::invalid_argument);
  EXPECT_THROW(batch.add_fix({0, 1, place, 0.5, {}, 0.0, 1}), std::invalid_argument);
}

// Attitude, position and velocity of the later state are known to 0.1 rad, m and m/s.
class Known final : public Factor {
 public:
  explicit Known(const NavState& state) : state_(state) {}
  int dimension() const override { return 9; }
  void evaluate(const NavState& /*a*/, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override {
    r = local(state_, b).head<9>() / 0.1;
    if (!Ja) return;
    Ja->setZero(9, kStateDim);
    *Jb = local_jacobian(state_, b).topRows<9>() / 0.1;
  }

 private:
  NavState state_;
};

// A robot that turns and changes its speed, at a time in s.
NavState turning(double t) {
  NavState x;
  x.time = from_seconds(t);
  x.q_odom_body = Eigen::AngleAxisd(0.4 * t, Eigen::Vector3d::UnitZ());
  x.p_odom.x() = t + 0.5 * std::sin(t);
  x.v_odom.x() = 1 + 0.5 * std::cos(t);
  return x;
}

// Its fixes are of an antenna 1 m off, and late.
TEST(Batch, FindsTheAntennaOfFixes) {
  constexpr double kStep = 0.1, kDelay = 0.08;
  const Eigen::Vector3d place(0.8, -0.6, 0.0);
  Batch batch(turning(0), origin_prior(turning(0), StateVector::Constant(0.1)));
  batch.set_antennas({{0.5, 0.05}});
  Batch known = batch;
  known.set_antennas({{}});
  for (std::size_t i = 1; i <= 100; ++i) {
    const double t = kStep * static_cast<double>(i);
    const NavState late = turning(t - kDelay);
    const Eigen::Vector2d p = (late.p_odom + late.q_odom_body * place).head<2>();
    const FixFactor fix(p, 1e-4 * Eigen::Matrix2d::Identity(), Eigen::Vector3d::Zero(), 1.0, kStep);
    for (Batch* each : {&batch, &known}) {
      each->add_state(turning(t));
      each->add_factor(i - 1, i, std::make_shared<Known>(turning(t)));
      each->add_factor(i - 1, i, std::make_shared<RandomWalkFactor>(1e-3, 1e-3, 1e-3));
      each->add_fix({i - 1, i, fix});
    }
  }
  std::vector<Eigen::Vector3d> found;
  const NavState last = turning(100 * kStep);
  EXPECT_LT((batch.solve({}, &found).back().p_odom - last.p_odom).norm(), 0.02);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT((found[0].head<2>() - place.head<2>()).norm(), 0.02);
  EXPECT_NEAR(found[0].z(), kDelay, 0.01);
  EXPECT_GT((known.solve({}, &found).back().p_odom - last.p_odom).norm(), 0.3);
  EXPECT_TRUE(found[0].isZero());
}

// A wheel that reports 10.2 m between two surveyed marks 10 m apart.
TEST(Batch, FixesMeasureAScaleThatAccelerationsDoNotShow) {
  const auto solved = [](bool with_fixes) {
    StateVector sigma = StateVector::Constant(1e-3);
    sigma[row::kScale] = 0.05;
    Batch batch(NavState(), origin_prior(NavState(), sigma));
    NavState second;
    second.time = from_seconds(20.0);
    second.p_odom.x() = 10.2;
    batch.add_state(second);
    WheelIncrement wheel(Eigen::Vector3d::Zero());
    for (int i = 0; i < 100; ++i) wheel.integrate(Eigen::Vector3d::Zero(), 0.2, 0.102);
    batch.add_factor(0, 1,
                     std::make_shared<WheelFactor>(wheel, Eigen::Vector3d::Zero(),
                                                   Eigen::Vector3d::Constant(1e-6), 100.0));
    batch.add_factor(0, 1, std::make_shared<RandomWalkFactor>(1e-6, 1e-6, 1e-6));
    batch.hold_scale(1.0);
    if (with_fixes) batch.free_scale();
    for (const double share : {0.0, 1.0})
      if (with_fixes)
        batch.add_fix({0, 1,
                       FixFactor({10.0 * share, 0.0}, 1e-6 * Eigen::Matrix2d::Identity(),
                                 Eigen::Vector3d::Zero(), share, 20.0)});
    return batch.solve({}).back();
  };
  EXPECT_NEAR(solved(false).wheel_scale, 1.0, 1e-5);
  EXPECT_NEAR(solved(false).p_odom.x(), 10.2, 1e-3);
  EXPECT_NEAR(solved(true).wheel_scale, 1.02, 1e-3);
  EXPECT_NEAR(solved(true).p_odom.x(), 10.0, 1e-2);
}

TEST(Batch, ScaleWalksByTheTimeBetweenStates) {
  Batch batch(NavState(), origin_prior(NavState(), StateVector::Constant(1e-3)));
  NavState second;
  second.time = from_seconds(4.0);
  second.wheel_scale = 1.1;
  batch.add_state(second);
  std::vector<double> told;
  batch.add_factor(0, 1, std::make_shared<Listener>(told));
  batch.set_scale_walk(0.005);
  EXPECT_EQ(told, std::vector<double>{0.01});
  Residual r;
  RandomWalkFactor(1e-5, 1e-5, 1e-7)
      .with_scale_step(0.01)
      ->evaluate(NavState(), second, r, nullptr, nullptr);
  EXPECT_NEAR(r[6], 10.0, 1e-9);
}

// What the count of an encoder tells of the way through a gap of its messages.

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
