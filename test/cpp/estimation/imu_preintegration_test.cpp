// Preintegration against an independent integration in small steps, its covariance against numeric
// derivatives of that integration, and both against drawn noise.
#include "estimation/increments/imu_preintegration.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "estimation/kernels/so3.h"
#include "support/derivative.h"

namespace gprodom {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
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

TEST(ImuPreintegration, CovarianceEqualsThatOfDrawnNoise) {
  const auto truth = samples(60, 21);
  auto integrate = [&](std::mt19937* engine) {
    std::normal_distribution<double> n;
    ImuPreintegration imu(kNoise, Vector3d::Zero(), Vector3d::Zero());
    for (Sample s : truth) {
      if (engine)
        for (int k = 0; k < 3; ++k) {
          s.rate[k] += n(*engine) * kNoise.gyro_density / std::sqrt(kDt);
          s.force[k] += n(*engine) * force_density()[k] / std::sqrt(kDt);
        }
      imu.integrate(s.force, s.rate, kDt);
    }
    return imu;
  };
  const ImuPreintegration clean = integrate(nullptr);
  const Eigen::LLT<Matrix9d> llt(clean.covariance());
  std::mt19937 engine(5);
  constexpr int kDraws = 1000;
  double nees = 0;
  for (int i = 0; i < kDraws; ++i) {
    const auto d = integrate(&engine).delta();
    Vector9d e;
    e << so3::log(clean.delta().q.conjugate() * d.q), d.v - clean.delta().v, d.p - clean.delta().p;
    nees += llt.matrixL().solve(e).squaredNorm();
  }
  // Chi-square of 9 * 1000 degrees: mean 9, deviation sqrt(18 / 1000); four deviations.
  EXPECT_NEAR(nees / kDraws, 9.0, 4 * std::sqrt(18.0 / kDraws));
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
