// Residuals of the pose graph, whitened, with analytic derivatives by (x, y, yaw) of its nodes.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <cmath>

#include "gprodom/pose_graph.h"

namespace gprodom {

// Into (-pi, pi].
inline double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

// Pose of node b in the frame of node a, with its derivatives.
struct RelativePose {
  Eigen::Vector3d value;  // x, y, yaw; m, rad
  Eigen::Matrix3d d_a, d_b;
  RelativePose(const double* a, const double* b) {
    const Eigen::Matrix2d RT = Eigen::Rotation2Dd(-a[2]).toRotationMatrix();
    const Eigen::Vector2d local = RT * Eigen::Vector2d(b[0] - a[0], b[1] - a[1]);
    value << local, wrapped(b[2] - a[2]);
    d_a.setZero();
    d_a.topLeftCorner<2, 2>() = -RT;
    d_a.topRightCorner<2, 1>() << local.y(), -local.x();
    d_a(2, 2) = -1;
    d_b.setZero();
    d_b.topLeftCorner<2, 2>() = RT;
    d_b(2, 2) = 1;
  }
};

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// W ([x, y](a to b) - (1 - e) measured; yaw - measured), e the scale error: reported distances are
// (1 + e) times the true ones, to first order.
class StepFactor final : public ceres::SizedCostFunction<3, 3, 3, 1> {
 public:
  StepFactor(const PlanarPose& measured, const Eigen::Matrix3d& whitening)
      : measured_(measured), whitening_(whitening) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const RelativePose relative(x[0], x[1]);
    Eigen::Vector3d error = relative.value;
    error.head<2>() -= (1 - x[2][0]) * measured_.p;
    error[2] = wrapped(error[2] - measured_.yaw);
    Eigen::Map<Eigen::Vector3d>{residuals} = whitening_ * error;
    if (!jacobians) return true;
    if (jacobians[0]) Eigen::Map<RowMajor3d>{jacobians[0]} = whitening_ * relative.d_a;
    if (jacobians[1]) Eigen::Map<RowMajor3d>{jacobians[1]} = whitening_ * relative.d_b;
    if (jacobians[2])
      Eigen::Map<Eigen::Vector3d>{jacobians[2]} = whitening_.leftCols<2>() * measured_.p;
    return true;
  }

 private:
  PlanarPose measured_;
  Eigen::Matrix3d whitening_;
};

// [x - offset; y - lateral; yaw - (mirrored ? pi : 0)] over their standard deviations.
class RevisitFactor final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  RevisitFactor(const RevisitEdge& edge, double yaw_sigma)
      : measured_(edge.offset_m, edge.lateral_m, edge.mirrored ? M_PI : 0.0),
        weight_(1 / edge.sigma_m, 1 / edge.lateral_sigma_m, 1 / yaw_sigma) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const RelativePose relative(x[0], x[1]);
    Eigen::Vector3d error = relative.value - measured_;
    error[2] = wrapped(error[2]);
    Eigen::Map<Eigen::Vector3d>{residuals} = weight_.cwiseProduct(error);
    if (!jacobians) return true;
    if (jacobians[0]) Eigen::Map<RowMajor3d>{jacobians[0]} = weight_.asDiagonal() * relative.d_a;
    if (jacobians[1]) Eigen::Map<RowMajor3d>{jacobians[1]} = weight_.asDiagonal() * relative.d_b;
    return true;
  }

 private:
  Eigen::Vector3d measured_, weight_;
};

class ScalePrior final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit ScalePrior(double sigma) : weight_(1 / sigma) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * x[0][0];
    if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
    return true;
  }

 private:
  double weight_;
};

}  // namespace gprodom
