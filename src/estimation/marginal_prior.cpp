#include "estimation/marginal_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "estimation/kernels/so3.h"

namespace gprodom {

void MarginalPrior::add_scale(double scale, double sigma) {
  const Eigen::Index rows = A.rows();
  A.conservativeResize(rows + 1, Eigen::NoChange);
  A.row(rows).setZero();
  A(rows, row::kScale) = 1 / sigma;
  b.conservativeResize(rows + 1);
  b[rows] = (x0.front().wheel_scale - scale) / sigma;
}

// Far beyond the error of the start that the solver is given, and near enough for its equations.
void MarginalPrior::free_place() {
  constexpr double kFreePlace = 1e3;  // m, rad
  const int columns[] = {row::kTheta + 2, row::kP, row::kP + 1};
  const Eigen::Index rows = A.rows();
  A.conservativeResize(rows + 3, Eigen::NoChange);
  b.conservativeResize(rows + 3);
  A.bottomRows(3).setZero();
  b.tail(3).setZero();
  for (int i = 0; i < 3; ++i) {
    A.col(columns[i]).setZero();
    A(rows + i, columns[i]) = 1 / kFreePlace;
  }
}

void MarginalPrior::evaluate(const NavState* x, Eigen::VectorXd& r, Eigen::MatrixXd* J) const {
  const int n = states();
  r = b;
  if (J) J->resize(A.rows(), A.cols());
  for (int i = 0; i < n; ++i) {
    const auto Ai = A.middleCols<kStateDim>(i * kStateDim);
    r.noalias() += Ai * local(x0[i], x[i]);
    if (J) J->middleCols<kStateDim>(i * kStateDim).noalias() = Ai * local_jacobian(x0[i], x[i]);
  }
}

void MarginalPrior::move_to(const NavState* x) {
  for (int i = 0; i < states(); ++i)
    b.noalias() += A.middleCols<kStateDim>(i * kStateDim) * local(x0[i], x[i]);
  x0.assign(x, x + states());
}

void MarginalPrior::shift_origin(const Eigen::Vector3d& by) {
  for (NavState& x : x0) x.p_odom -= by;
  for (int i = 0; i < states(); ++i) {
    const Eigen::MatrixXd turned = A.middleCols<3>(i * kStateDim + row::kP) * so3::skew(by);
    A.middleCols<3>(i * kStateDim + row::kTheta) += turned;
  }
}

// The unobservable errors: the same directions for every state (nav_state.h).
Eigen::Vector4d MarginalPrior::common_information() const {
  Eigen::Vector4d information;
  for (int i = 0; i < 4; ++i) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(A.rows());
    for (int k = 0; k < states(); ++k) sum += A.col(k * kStateDim + row::kUnmeasured[i]);
    information[i] = sum.squaredNorm();
  }
  return information;
}

void eliminate_first_state(Eigen::MatrixXd J, Eigen::VectorXd r, Eigen::MatrixXd& A,
                           Eigen::VectorXd& b) {
  const Eigen::Index columns = J.cols() - kStateDim;
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(J);  // in place
  r.applyOnTheLeft(qr.householderQ().adjoint());
  const Eigen::Index rows = std::clamp<Eigen::Index>(J.rows() - kStateDim, 0, columns);
  A = J.block(kStateDim, kStateDim, rows, columns).triangularView<Eigen::Upper>();
  b = r.segment(kStateDim, rows);
}

StateMatrix MarginalPrior::covariance() const { return (A.transpose() * A).inverse(); }

MarginalPrior gaussian_prior(const NavState& state, const StateMatrix& covariance) {
  MarginalPrior prior;
  prior.x0 = {state};
  prior.A = covariance.llt().matrixL().solve(StateMatrix::Identity());
  prior.b = StateVector::Zero();
  return prior;
}

}  // namespace gprodom
