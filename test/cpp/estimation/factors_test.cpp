// Analytic against numeric Jacobians of every factor and of the prior, at random states with
// attitudes up to 180 degrees and residual rotations up to 3 rad.
#include "estimation/factors.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <random>
#include <typeinfo>

#include "estimation/cost_function_factor.h"
#include "estimation/kernels/so3.h"
#include "estimation/marginal_prior.h"
#include "estimation/state_manifold.h"
#include "support/derivative.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(engine_);
  }
  Vector3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  Vector3d rotation(double max_angle) { return vector(1.0).normalized() * uniform(0, max_angle); }
  NavState state() {
    NavState x;
    x.q_odom_body = so3::exp(rotation(M_PI));
    x.p_odom = vector(50);
    x.v_odom = vector(3);
    x.gyro_bias = vector(0.02);
    x.accel_bias = vector(0.2);
    x.wheel_scale = uniform(0.9, 1.1);
    return x;
  }
  // A state near enough that the residual rotation between it and x's prediction is below 3 rad.
  NavState near(const NavState& x, const Eigen::Quaterniond& delta) {
    NavState y = state();
    y.q_odom_body = x.q_odom_body * delta * so3::exp(rotation(3.0));
    y.p_odom = x.p_odom + vector(2);
    return y;
  }

 private:
  std::mt19937 engine_;
};

template <class F>
MatrixXd numeric(const F& f) {
  return numeric_jacobian(kStateDim, 1e-3, f);
}

void expect_same(const MatrixXd& analytic, const MatrixXd& n, const char* what) {
  for (Eigen::Index i = 0; i < n.rows(); ++i)
    EXPECT_LT((analytic.row(i) - n.row(i)).norm(), 1e-6 * (1e-6 + n.row(i).norm()))
        << what << ", row " << i << "\nanalytic " << analytic.row(i) << "\nnumeric  " << n.row(i);
}

void check(const Factor& factor, const NavState& a, const NavState& b) {
  SCOPED_TRACE(typeid(factor).name());
  Residual r;
  Jacobian Ja, Jb;
  factor.evaluate(a, b, r, &Ja, &Jb);
  ASSERT_EQ(r.size(), factor.dimension());
  auto residual = [&](const NavState& x, const NavState& y) {
    Residual v;
    factor.evaluate(x, y, v, nullptr, nullptr);
    return VectorXd(v);
  };
  expect_same(Ja, numeric([&](const StateVector& d) { return residual(retract(a, d), b); }),
              "earlier state");
  expect_same(Jb, numeric([&](const StateVector& d) { return residual(a, retract(b, d)); }),
              "later state");

  // These may be, or are, of the place itself.
  if (dynamic_cast<const CostFunctionFactor*>(&factor) || factor.measures_place()) return;
  // Turning about gravity and shifting both states changes nothing: the global directions that
  // no factor may observe are the same vectors at every state.
  Eigen::Matrix<double, kStateDim, 4> global = Eigen::Matrix<double, kStateDim, 4>::Zero();
  global(row::kTheta + 2, 3) = 1;
  global.block<3, 3>(row::kP, 0).setIdentity();
  EXPECT_LT(((Ja + Jb) * global).cwiseAbs().maxCoeff(), 1e-9 * Ja.cwiseAbs().maxCoeff());
}

const Vector3d kGravity(0, 0, -9.80665);

ImuPreintegration some_preintegration(Random& random) {
  ImuPreintegration p({1.6e-4, 5.9e-4}, random.vector(0.02), random.vector(0.2));
  for (int i = 0; i < 40; ++i)
    p.integrate(random.vector(3) + Vector3d(0, 0, 9.8), random.vector(2), 0.005);
  return p;
}

TEST(Factors, ImuJacobians) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const ImuPreintegration p = some_preintegration(random);
    const NavState a = random.state();
    check(ImuFactor(p, kGravity), a, random.near(a, p.delta(a.gyro_bias, a.accel_bias).q));
  }
}

TEST(Factors, WheelJacobians) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector3d bias = random.vector(0.02);
    WheelIncrement w(bias), longer(bias);
    for (int k = 0; k < 20; ++k) {
      const Vector3d rate = random.vector(2);
      const double way = random.uniform(-0.02, 0.02);
      w.integrate(rate, 0.01, way);
      longer.integrate(rate, 0.01, std::exp(-0.3) * way);
    }
    const Vector3d lever = random.vector(1);
    const Vector3d variance = w.variance({0.01, 0.005, 0.02, 1e-3});
    const NavState a = random.state(), b = random.state();
    check(WheelFactor(w, lever, variance, 0), a, b);
    const auto slipped = WheelFactor(w, lever, variance, 0).with_slip(-0.3);
    check(*slipped, a, b);
    Residual r, expected;
    slipped->evaluate(a, b, r, nullptr, nullptr);
    WheelFactor(longer, lever, variance, 0).evaluate(a, b, expected, nullptr, nullptr);
    EXPECT_LT((r - expected).norm(), 1e-9 * expected.norm());
    check(WheelFactor(w, lever, variance, 0,
                      std::make_shared<WheelSlipTerm>(WheelSlipTerm{-0.3, 0.1})),
          a, b);
    check(WheelFactor(w, lever, variance, 0, nullptr,
                      std::make_shared<WheelPlaceTerm>(WheelPlaceTerm{0.4})),
          a, b);
    check(WheelDistanceFactor(w.distance(), 0.01, lever, 0), a, b);
  }
}

// A body that turns on the spot. Its wheel, at y, rolls backwards by y times the turn; what the
// window learns of y later counts in intervals of before.
TEST(Factors, AWheelCountsAsItsPlaceIsKnown) {
  constexpr double kTurn = 0.2, kY = 0.3, kSigma = 0.01;
  WheelIncrement w(Vector3d::Zero());
  for (int k = 0; k < 20; ++k) w.integrate({0, 0, kTurn / (20 * 0.01)}, 0.01, -kY * kTurn / 20);
  NavState a, b;
  b.q_odom_body = Eigen::AngleAxisd(kTurn, Vector3d::UnitZ());
  const auto place = std::make_shared<WheelPlaceTerm>();
  const WheelFactor factor(w, Vector3d::Zero(), Vector3d::Constant(kSigma * kSigma), 0, nullptr,
                           place);
  const auto forwards = [&] {
    Residual r;
    factor.evaluate(a, b, r, nullptr, nullptr);
    return r[0];
  };
  EXPECT_NEAR(forwards(), kY * kTurn / kSigma, 0.1);
  place->y_m = kY;
  EXPECT_NEAR(forwards(), 0.0, 0.05);
}

// Each between two states that have nothing to do with each other, but for a standstill.
TEST(Factors, OtherJacobians) {
  using Form = DisplacementFactor::Form;
  const Eigen::Matrix2d covariance{{0.04, 0.01}, {0.01, 0.09}};
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const NavState a = random.state(), b = random.state();
    check(StandstillFactor({}), a, random.near(a, Eigen::Quaterniond::Identity()));
    check(RandomWalkFactor(1e-5, 1e-3, 1e-4), a, b);
    check(SpeedWalkFactor(0.3), a, b);
    DisplacementFactor::Measurement moved{random.uniform(-1, 1), 0.05, 0.03, -0.07, Form::kNorm, 0};
    check(DisplacementFactor(moved, random.vector(1)), a, b);
    moved.form = Form::kSigned;
    check(DisplacementFactor(moved, random.vector(1), random.vector(1)), a, b);
    RevisitEdge edge{0, 1};
    edge.memory_at = {random.vector(0.5).head<2>(), random.uniform(-1, 1)};
    edge.query_at = {random.vector(0.5).head<2>(), random.uniform(-1, 1)};
    edge.offset_m = random.uniform(-1, 1);
    edge.lateral_m = random.uniform(-1, 1);
    check(RevisitFactor(edge), a, b);
  }
}

TEST(Factors, FixJacobians) {
  const Eigen::Matrix2d covariance{{0.04, 0.01}, {0.01, 0.09}};
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    const NavState a = random.state(), b = random.state();
    const FixFactor fix(random.vector(50).head<2>(), covariance, random.vector(1),
                        random.uniform(0, 1), random.uniform(0.1, 1));
    const Vector3d antenna = random.vector(1);
    FixFactor::Jacobians J;
    fix.evaluate(a, b, antenna, &J);
    const MatrixXd n =
        numeric_jacobian(2 * kStateDim + 3, 1e-3, [&](const VectorXd& d) -> VectorXd {
          return fix.evaluate(retract(a, d.head<kStateDim>()),
                              retract(b, d.segment<kStateDim>(kStateDim)), antenna + d.tail<3>(),
                              nullptr);
        });
    MatrixXd analytic(2, n.cols());
    analytic << J.a, J.b, J.antenna;
    expect_same(analytic, n, "fix");
  }
}

TEST(Factors, PriorJacobians) {
  Random random(6);
  for (int i = 0; i < 50; ++i) {
    MarginalPrior prior;
    const NavState x0 = random.state();
    prior.x0 = {x0, random.state()};
    prior.A = MatrixXd::Random(20, 2 * kStateDim);
    prior.b = VectorXd::Random(20);
    NavState x[2] = {random.near(x0, Eigen::Quaterniond::Identity()), prior.x0[1]};
    VectorXd r;
    MatrixXd J;
    prior.evaluate(x, r, &J);
    for (int k = 0; k < 2; ++k) {
      const MatrixXd n = numeric([&](const StateVector& d) {
        NavState y[2] = {x[0], x[1]};
        y[k] = retract(x[k], d);
        VectorXd v;
        prior.evaluate(y, v, nullptr);
        return v;
      });
      expect_same(J.middleCols<kStateDim>(k * kStateDim), n, "prior");
    }
  }
}

// Of every part of a state at two moments: attitude, position and velocity of both, and what is
// constant of the first.
struct EveryPart {
  template <typename T>
  bool operator()(const T* q0, const T* p0, const T* v0, const T* bg, const T* ba, const T* scale,
                  const T* q1, const T* p1, const T* v1, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = p1[i] - p0[i] * scale[0] + v0[i] * v1[i];
    for (int i = 0; i < 4; ++i) r[3 + i] = q0[i] * q1[(i + 1) % 4] + q1[i] * p1[2];
    r[7] = bg[0] * 100.0 + bg[1] * ba[2] + bg[2];
    r[8] = ba[0] * ba[1] + scale[0];
    return true;
  }
};

UserFactor every_part() {
  UserFactor user;
  user.times = {0, 1};
  for (std::size_t moment : {0, 1}) {
    for (StatePart part : {StatePart::kAttitude, StatePart::kPosition, StatePart::kVelocity})
      user.blocks.push_back({moment, part});
    if (moment > 0) break;
    for (StatePart part : {StatePart::kGyroBias, StatePart::kAccelBias, StatePart::kWheelScale})
      user.blocks.push_back({moment, part});
  }
  user.cost =
      std::make_shared<ceres::AutoDiffCostFunction<EveryPart, 9, 4, 3, 3, 3, 3, 1, 4, 3, 3>>(
          new EveryPart);
  return user;
}

TEST(Factors, CostFunctionJacobians) {
  Random random(9);
  const UserFactor user = every_part();
  ASSERT_EQ(malformed(user), "");
  for (int k = 0; k < 20; ++k) {
    const NavState a = random.state(), b = random.state();
    std::vector<CostFunctionFactor::Moment> moments;
    const auto origin = std::make_shared<Eigen::Vector3d>(30, -20, 1);
    for (const NavState* x : {&a, &b}) {
      ImuPreintegration since({1e-4, 1e-3}, x->gyro_bias, x->accel_bias);
      for (int i = 0; i < 7; ++i) since.integrate(random.vector(10), random.vector(2), 0.02);
      moments.push_back({x == &b, since});
    }
    check(CostFunctionFactor(user, moments, 9.8, origin), a, b);
    moments[1].of_b = false;  // both moments in one state's interval
    check(CostFunctionFactor(user, moments, 9.8, origin), a, b);
  }
}

TEST(StateManifold, IsTheChartOfTheStates) {
  Random random(4);
  const StateManifold manifold;
  for (int k = 0; k < 20; ++k) {
    const NavState x = random.state();
    StateParameters at_x, at_y;
    to_parameters(x, at_x.data());
    StateVector d;
    d << random.rotation(1.0), random.vector(1), random.vector(1), random.vector(1),
        random.vector(1), 0.1;
    ASSERT_TRUE(manifold.Plus(at_x.data(), d.data(), at_y.data()));
    EXPECT_LT(local(retract(x, d), from_parameters(at_y.data())).norm(), 1e-12);
    StateVector back;
    ASSERT_TRUE(manifold.Minus(at_y.data(), at_x.data(), back.data()));
    EXPECT_LT((back - d).norm(), 1e-12);

    ParameterJacobian plus;
    ASSERT_TRUE(manifold.PlusJacobian(at_x.data(), plus.data()));
    const MatrixXd n = numeric([&](const StateVector& e) {
      StateParameters moved;
      manifold.Plus(at_x.data(), e.data(), moved.data());
      return VectorXd(Eigen::Map<const VectorXd>(moved.data(), ambient::kSize));
    });
    expect_same(plus, n, "Plus");
    Eigen::Matrix<double, kStateDim, ambient::kSize, Eigen::RowMajor> minus;
    ASSERT_TRUE(manifold.MinusJacobian(at_x.data(), minus.data()));
    EXPECT_LT((minus * plus - StateMatrix::Identity()).norm(), 1e-12);
  }
}

// What is believed of slip is looked up at each evaluation: it is learnt while the factor is in
// use.
TEST(WheelFactor, FollowsWhatIsBelievedOfSlip) {
  constexpr double kReported = 0.2, kSigma = 0.01;
  NavState a, b;
  b.p_odom.x() = kReported * std::exp(-0.3);
  WheelIncrement increment;
  increment.integrate(Vector3d::Zero(), 0.2, kReported);
  const auto slip = std::make_shared<WheelSlipTerm>();
  const WheelFactor factor(increment, Vector3d::Zero(), Vector3d::Constant(kSigma * kSigma), 0,
                           slip);
  Residual r;
  factor.evaluate(a, b, r, nullptr, nullptr);
  const double missing = kReported - b.p_odom.x();
  EXPECT_NEAR(r[0], -missing / kSigma, 1e-9);
  slip->sigma = missing / kReported;  // what is missing is one standard deviation
  factor.evaluate(a, b, r, nullptr, nullptr);
  EXPECT_NEAR(r[0], -1 / std::hypot(1, kSigma / missing), 1e-9);
  slip->l = -0.3;
  factor.evaluate(a, b, r, nullptr, nullptr);
  EXPECT_NEAR(r[0], 0.0, 1e-9);
  factor.with_slip(0.3)->evaluate(a, b, r, nullptr, nullptr);  // the map's slip is beside it
  EXPECT_NEAR(r[0], -missing / kSigma, 1e-9);
}

// At the true state the gradient by the scale must be zero on the mean, whatever the wheel's noise.
// In true distance, x - d / s, the square of the noise would stand in it.
TEST(WheelFactor, NoiseOfTheWheelDoesNotPushTheScale) {
  Noise normal(5);
  constexpr double kStep = 0.1, kSigma = 0.02, kScale = 1.03;
  NavState a, b;
  a.wheel_scale = b.wheel_scale = kScale;
  b.p_odom.x() = kStep;
  double sum = 0, squares = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    WheelIncrement increment;
    increment.integrate(Vector3d::Zero(), 0.2, kScale * kStep + kSigma * normal());
    const WheelFactor factor(increment, Vector3d::Zero(), Vector3d::Constant(kSigma * kSigma), 0);
    Residual r;
    Jacobian Ja, Jb;
    factor.evaluate(a, b, r, &Ja, &Jb);
    const double gradient = Ja.col(row::kScale).dot(r);
    sum += gradient;
    squares += gradient * gradient;
  }
  EXPECT_LT(std::abs(sum), 4 * std::sqrt(squares));
}

}  // namespace
}  // namespace gprodom
