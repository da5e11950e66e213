#include "estimation/factors.h"

#include <ceres/loss_function.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "estimation/kernels/so3.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using so3::skew;

namespace {

void resize(Residual& r, Jacobian* Ja, Jacobian* Jb, int rows) {
  r.resize(rows);
  if (Ja) Ja->setZero(rows, kStateDim);
  if (Jb) Jb->setZero(rows, kStateDim);
}

// A point fixed to the body and its derivative in the chart: c = p + R l moves by
// skew(-c) theta + rho.
struct BodyPoint {
  Vector3d c;
  BodyPoint(const NavState& x, const Vector3d& lever_arm)
      : c(x.p_odom + x.q_odom_body * lever_arm) {}
  Matrix3d d_theta() const { return -skew(c); }
};

// A norm with a derivative everywhere: sqrt(x^2 + eps^2), eps 0.1 mm.
double smooth_norm(const Vector3d& x) { return std::sqrt(x.squaredNorm() + 1e-8); }

// Cauchy: rho(r) = c^2/2 log(1 + (r/c)^2), and its weight rho'(r) / r.
double cauchy_cost(double r, double c) {
  return c > 0 ? 0.5 * c * c * std::log1p(r * r / (c * c)) : 0.5 * r * r;
}
double cauchy_weight(double r, double c) { return c > 0 ? 1 / (1 + r * r / (c * c)) : 1.0; }

}  // namespace

double robust_cost(const Factor& factor, const Residual& r) {
  if (const ceres::LossFunction* loss = factor.loss()) {
    double rho[3];
    loss->Evaluate(r.squaredNorm(), rho);
    return 0.5 * rho[0];
  }
  double sum = 0;
  for (int i = 0; i < r.size(); ++i) sum += cauchy_cost(r[i], factor.robust_threshold(i));
  return sum;
}

void weight_rows(const Factor& factor, Residual& r, Jacobian& Ja, Jacobian& Jb) {
  if (const ceres::LossFunction* loss = factor.loss()) {
    double rho[3];
    loss->Evaluate(r.squaredNorm(), rho);
    const double w = std::sqrt(std::max(0.0, rho[1]));
    r *= w;
    Ja *= w;
    Jb *= w;
    return;
  }
  for (int i = 0; i < r.size(); ++i) {
    const double c = factor.robust_threshold(i);
    if (c <= 0) continue;
    const double w = std::sqrt(cauchy_weight(r[i], c));
    r[i] *= w;
    Ja.row(i) *= w;
    Jb.row(i) *= w;
  }
}

ImuFactor::ImuFactor(const ImuPreintegration& preintegration, const Vector3d& gravity_odom)
    : preintegration_(preintegration), gravity_odom_(gravity_odom) {
  // With covariance L L^T the whitening is L^-1.
  const Eigen::LLT<Matrix9d> llt(preintegration.covariance());
  if (preintegration.duration() <= 0 || llt.info() != Eigen::Success)
    throw std::invalid_argument("ImuFactor: preintegrated covariance is not positive definite");
  whitening_ = llt.matrixL().solve(Matrix9d::Identity());
}

void ImuFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                         Jacobian* Jb) const {
  const double dt = preintegration_.duration();
  const Vector3d g = gravity_odom_;
  const Matrix3d RaT = a.R_odom_body().transpose();
  const Vector3d dbg = a.gyro_bias - preintegration_.gyro_bias();
  const auto delta = preintegration_.delta(a.gyro_bias, a.accel_bias);

  const Eigen::Quaterniond error = delta.q.conjugate() * a.q_odom_body.conjugate() * b.q_odom_body;
  const Vector3d phi = so3::log(error);
  const Vector3d dv = b.v_odom - a.v_odom - g * dt;
  const Vector3d dp = b.p_odom - a.p_odom - a.v_odom * dt - 0.5 * g * dt * dt;
  Eigen::Matrix<double, 9, 1> raw;
  raw << phi, RaT * dv - delta.v, RaT * dp - delta.p;

  r = whitening_ * raw;
  if (!Ja) return;

  // In blocks of three rows. The whitening is triangular: it mixes a block only with those above
  // it.
  Ja->setZero(9, kStateDim);
  Jb->setZero(9, kStateDim);
  const auto add = [this](Jacobian& J, int block, int column, const Matrix3d& d) {
    for (int i = block; i < 3; ++i)
      J.block<3, 3>(3 * i, column) += whitening_.block<3, 3>(3 * i, 3 * block).lazyProduct(d);
  };
  const Matrix3d Jr_inv = so3::right_jacobian_inverse(phi);
  const Matrix3d theta = Jr_inv * b.R_odom_body().transpose();
  add(*Ja, 0, row::kTheta, -theta);
  add(*Jb, 0, row::kTheta, theta);
  // The correction Exp(dq_dbg dbg) is on the right of dq; so its inverse is on the left of the
  // error.
  add(*Ja, 0, row::kBg,
      -Jr_inv * error.conjugate().toRotationMatrix() *
          so3::right_jacobian(preintegration_.dq_dbg() * dbg) * preintegration_.dq_dbg());

  // A rotation of state a rotates what is measured in its frame. In the chart, theta also rotates v
  // and p.
  add(*Ja, 1, row::kTheta, RaT * skew(b.v_odom - g * dt));
  add(*Ja, 1, row::kV, -RaT);
  add(*Ja, 1, row::kBg, -preintegration_.dv_dbg());
  add(*Ja, 1, row::kBa, -preintegration_.dv_dba());
  add(*Jb, 1, row::kTheta, -RaT * skew(b.v_odom));
  add(*Jb, 1, row::kV, RaT);

  add(*Ja, 2, row::kTheta, RaT * skew(b.p_odom - 0.5 * g * dt * dt));
  add(*Ja, 2, row::kP, -RaT);
  add(*Ja, 2, row::kV, -RaT * dt);
  add(*Ja, 2, row::kBg, -preintegration_.dp_dbg());
  add(*Ja, 2, row::kBa, -preintegration_.dp_dba());
  add(*Jb, 2, row::kTheta, -RaT * skew(b.p_odom));
  add(*Jb, 2, row::kP, RaT);
}

RandomWalkFactor::RandomWalkFactor(double gyro_bias_sigma, double accel_bias_sigma,
                                   double scale_sigma) {
  weight_ << Vector3d::Constant(1 / gyro_bias_sigma), Vector3d::Constant(1 / accel_bias_sigma),
      1 / scale_sigma;
}

void RandomWalkFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                                Jacobian* Jb) const {
  resize(r, Ja, Jb, 7);
  r << b.gyro_bias - a.gyro_bias, b.accel_bias - a.accel_bias, b.wheel_scale - a.wheel_scale;
  r = weight_.cwiseProduct(r);
  if (!Ja) return;
  Ja->rightCols<7>().diagonal() = -weight_;
  Jb->rightCols<7>().diagonal() = weight_;
}

std::shared_ptr<const Factor> RandomWalkFactor::with_scale_step(double sigma) const {
  auto other = std::make_shared<RandomWalkFactor>(*this);
  other->weight_[6] = 1 / sigma;
  return other;
}

WheelFactor::WheelFactor(const WheelIncrement& increment, const Vector3d& lever_arm,
                         const Vector3d& variance, double robust_threshold,
                         std::shared_ptr<const WheelSlipTerm> slip,
                         std::shared_ptr<const WheelPlaceTerm> place)
    : increment_(increment),
      lever_arm_(lever_arm),
      robust_threshold_(robust_threshold),
      variance_(variance),
      slip_(std::move(slip)),
      place_(std::move(place)) {}

void WheelFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                           Jacobian* Jb) const {
  resize(r, Ja, Jb, 3);
  const Matrix3d RaT = a.R_odom_body().transpose();
  const Vector3d wheel_at(lever_arm_.x(), place_ ? place_->y_m : lever_arm_.y(), lever_arm_.z());
  const BodyPoint ca(a, wheel_at), cb(b, wheel_at);
  const double s = a.wheel_scale;
  const double stretch = slip_ ? std::exp(slip_->l) : 1.0;
  const Matrix3d d_dbg = stretch * increment_.d_dbg();
  const Vector3d measured =
      stretch * increment_.displacement() + d_dbg * (a.gyro_bias - increment_.gyro_bias());
  Vector3d variance = variance_;
  if (slip_) variance[0] += std::pow(slip_->sigma * stretch * increment_.distance(), 2);
  const Vector3d weight = variance.cwiseSqrt().cwiseInverse();
  // The forward row is in reported distance, the others are in true distance.
  const Vector3d moved = RaT * (cb.c - ca.c), unit(s, 1, 1);
  r = weight.cwiseProduct(unit).cwiseProduct(moved - measured / s);
  if (!Ja) return;
  const Matrix3d W = weight.cwiseProduct(unit).asDiagonal();
  // d/dtheta_a of R_a^T (c_b - c_a) is R_a^T skew(c_b), since c_a rotates with the frame.
  Ja->block<3, 3>(0, row::kTheta) = W * RaT * skew(cb.c);
  Ja->block<3, 3>(0, row::kP) = -W * RaT;
  Ja->block<3, 3>(0, row::kBg) = -W * d_dbg / s;
  Ja->col(row::kScale) = W * measured / (s * s);
  (*Ja)(0, row::kScale) = weight[0] * moved.x();
  Jb->block<3, 3>(0, row::kTheta) = W * RaT * cb.d_theta();
  Jb->block<3, 3>(0, row::kP) = W * RaT;
}

std::shared_ptr<const Factor> WheelFactor::with_slip(double l) const {
  auto slipped = std::make_shared<WheelFactor>(*this);
  slipped->increment_ = increment_.stretched(std::exp(l + (slip_ ? slip_->l : 0.0)));
  slipped->slip_ = nullptr;
  return slipped;
}

WheelDistanceFactor::WheelDistanceFactor(double distance_m, double sigma_m,
                                         const Vector3d& lever_arm, double robust_threshold)
    : distance_m_(std::abs(distance_m)),
      sigma_m_(sigma_m),
      lever_arm_(lever_arm),
      robust_threshold_(robust_threshold) {}

void WheelDistanceFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                                   Jacobian* Jb) const {
  resize(r, Ja, Jb, 1);
  const BodyPoint ca(a, lever_arm_), cb(b, lever_arm_);
  const Vector3d d = cb.c - ca.c;
  const double norm = smooth_norm(d), s = a.wheel_scale;
  r[0] = (norm - distance_m_ / s) / sigma_m_;
  if (!Ja) return;
  const Eigen::RowVector3d u = d.transpose() / (norm * sigma_m_);
  Ja->block<1, 3>(0, row::kTheta) = -u * ca.d_theta();
  Ja->block<1, 3>(0, row::kP) = -u;
  (*Ja)(0, row::kScale) = distance_m_ / (s * s * sigma_m_);
  Jb->block<1, 3>(0, row::kTheta) = u * cb.d_theta();
  Jb->block<1, 3>(0, row::kP) = u;
}

void StandstillFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                                Jacobian* Jb) const {
  resize(r, Ja, Jb, 9);
  const double wr = 1 / sigmas_.rotation, wp = 1 / sigmas_.position, wv = 1 / sigmas_.velocity;
  const Matrix3d RaT = a.R_odom_body().transpose(), RbT = b.R_odom_body().transpose();
  const Vector3d phi = so3::log(a.q_odom_body.conjugate() * b.q_odom_body);
  r << wr * phi, wp * (RaT * (b.p_odom - a.p_odom)), wv * (RbT * b.v_odom);
  if (!Ja) return;
  const Matrix3d theta = wr * so3::right_jacobian_inverse(phi) * RbT;
  Ja->block<3, 3>(0, row::kTheta) = -theta;
  Ja->block<3, 3>(3, row::kTheta) = wp * RaT * skew(b.p_odom);
  Ja->block<3, 3>(3, row::kP) = -wp * RaT;
  Jb->block<3, 3>(0, row::kTheta) = theta;
  Jb->block<3, 3>(3, row::kTheta) = -wp * RaT * skew(b.p_odom);
  Jb->block<3, 3>(3, row::kP) = wp * RaT;
  Jb->block<3, 3>(6, row::kV) = wv * RbT;  // theta does not change the velocity in body
}

void SpeedWalkFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                               Jacobian* Jb) const {
  resize(r, Ja, Jb, 1);
  const Vector3d ahead_a = a.q_odom_body * Vector3d::UnitX(),
                 ahead_b = b.q_odom_body * Vector3d::UnitX();
  r[0] = (ahead_b.dot(b.v_odom) - ahead_a.dot(a.v_odom)) / sigma_;
  if (!Ja) return;
  // theta turns axis and velocity alike.
  Ja->block<1, 3>(0, row::kV) = -ahead_a.transpose() / sigma_;
  Jb->block<1, 3>(0, row::kV) = ahead_b.transpose() / sigma_;
}

void DisplacementFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                                  Jacobian* Jb) const {
  resize(r, Ja, Jb, 1);
  const auto& m = measurement_;
  const BodyPoint pa(a, lever_arm_a_), pb(b, lever_arm_b_);
  // Position at the measurement's own time, by the state's velocity. theta rotates it like c.
  const Vector3d ca = pa.c + m.offset_a_s * a.v_odom, cb = pb.c + m.offset_b_s * b.v_odom;
  const Vector3d d = cb - ca;
  const double w = 1 / m.sigma_m;
  Eigen::RowVector3d u;  // d r / d d
  Vector3d pivot;        // derivative of d by theta of a is skew(pivot), frame and point together
  if (m.form == Form::kSigned) {
    const Vector3d axis = a.q_odom_body * Vector3d::UnitX();
    r[0] = w * (axis.dot(d) - m.distance_m);
    u = w * axis.transpose();
    pivot = cb;
  } else {
    const double norm = smooth_norm(d);
    r[0] = w * (norm - std::abs(m.distance_m));
    u = w * d.transpose() / norm;
    pivot = ca;
  }
  if (!Ja) return;
  Ja->block<1, 3>(0, row::kTheta) = u * skew(pivot);
  Ja->block<1, 3>(0, row::kP) = -u;
  Ja->block<1, 3>(0, row::kV) = -m.offset_a_s * u;
  Jb->block<1, 3>(0, row::kTheta) = -u * skew(cb);
  Jb->block<1, 3>(0, row::kP) = u;
  Jb->block<1, 3>(0, row::kV) = m.offset_b_s * u;
}

double RevisitFactor::robust_threshold(int row) const {
  return row == 0 ? kRevisitRobustThreshold : 0.0;
}

void RevisitFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                             Jacobian* Jb) const {
  resize(r, Ja, Jb, 2);
  const BodyPoint ca(a, {edge_.memory_at.p.x(), edge_.memory_at.p.y(), 0.0});
  const BodyPoint cb(b, {edge_.query_at.p.x(), edge_.query_at.p.y(), 0.0});
  const Matrix3d turn = Eigen::AngleAxisd(edge_.memory_at.yaw, Vector3d::UnitZ()).matrix();
  const Matrix3d QT = (a.R_odom_body() * turn).transpose();
  const Eigen::Vector2d weight(1 / edge_.sigma_m, 1 / edge_.lateral_sigma_m);
  const Eigen::Vector2d measured(edge_.offset_m, edge_.lateral_m);
  r = weight.cwiseProduct((QT * (cb.c - ca.c)).head<2>() - measured);
  if (!Ja) return;
  const Eigen::Matrix<double, 2, 3> W = weight.asDiagonal() * QT.topRows<2>();
  // As for the wheel: the frame of a rotates with its point.
  Ja->block<2, 3>(0, row::kTheta) = W * skew(cb.c);
  Ja->block<2, 3>(0, row::kP) = -W;
  Jb->block<2, 3>(0, row::kTheta) = W * cb.d_theta();
  Jb->block<2, 3>(0, row::kP) = W;
}

FixFactor::FixFactor(const Eigen::Vector2d& p, const Eigen::Matrix2d& covariance,
                     const Vector3d& lever_arm, double share, double seconds)
    : p_(p), lever_arm_(lever_arm), share_(share), seconds_(seconds) {
  const Eigen::LLT<Eigen::Matrix2d> root(covariance);
  if (root.info() != Eigen::Success)
    throw std::invalid_argument("FixFactor: the covariance is not positive definite");
  whitening_ = root.matrixL().solve(Eigen::Matrix2d::Identity());
}

Eigen::Vector2d FixFactor::evaluate(const NavState& a, const NavState& b, const Vector3d& antenna,
                                    Jacobians* J) const {
  const Vector3d arm = lever_arm_ + Vector3d(antenna.x(), antenna.y(), 0.0);
  const BodyPoint ca(a, arm), cb(b, arm);
  const double share = share_ - antenna.z() / seconds_;
  const Vector3d seen = (1 - share) * ca.c + share * cb.c;
  const Eigen::Vector2d r = whitening_ * (seen.head<2>() - p_);
  if (!J) return r;
  const Eigen::Matrix<double, 2, 3> W = whitening_ * Eigen::Matrix<double, 2, 3>::Identity();
  J->a.setZero(2, kStateDim);
  J->b.setZero(2, kStateDim);
  J->a.block<2, 3>(0, row::kTheta) = (1 - share) * W * ca.d_theta();
  J->a.block<2, 3>(0, row::kP) = (1 - share) * W;
  J->b.block<2, 3>(0, row::kTheta) = share * W * cb.d_theta();
  J->b.block<2, 3>(0, row::kP) = share * W;
  const Matrix3d turned =
      (1 - share) * a.q_odom_body.toRotationMatrix() + share * b.q_odom_body.toRotationMatrix();
  J->antenna << W * turned.leftCols<2>(), -1 / seconds_ * W * (cb.c - ca.c);
  return r;
}

}  // namespace gprodom
