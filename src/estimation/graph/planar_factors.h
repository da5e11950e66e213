// Residuals of the pose graph, whitened, with analytic derivatives by (x, y, yaw) of its nodes.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <cmath>

#include "estimation/graph/pose_graph.h"
#include "estimation/planar_geometry.h"

namespace gprodom {

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

// W U ([x, y, yaw](a to b) - [e^l measured (x, y); measured yaw] - d_scale (s - s_measured)), with
// s the wheel's scale, l the slip of the step, and U = diag(e^-l, e^-l, 1): the error is in metres
// by the wheel, so that a track which is smaller as a whole does not have smaller errors. m, rad.
class PlanarStepFactor final : public ceres::SizedCostFunction<3, 3, 3, 1, 1> {
 public:
  PlanarStepFactor(const PlanarStep& step, const Eigen::Matrix3d& whitening)
      : step_(step), whitening_(whitening) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const RelativePose relative(x[0], x[1]);
    const Eigen::Vector2d travelled = std::exp(x[3][0]) * step_.measured.p;
    Eigen::Vector3d error = relative.value;
    error.head<2>() -= travelled;
    error -= step_.d_scale * (x[2][0] - step_.scale);
    error[2] = wrapped(error[2] - step_.measured.yaw);
    const double shorter = std::exp(-x[3][0]);
    const Eigen::Matrix3d weight = whitening_ * Eigen::Vector3d(shorter, shorter, 1.0).asDiagonal();
    Eigen::Map<Eigen::Vector3d>{residuals} = weight * error;
    if (!jacobians) return true;
    if (jacobians[0]) Eigen::Map<RowMajor3d>{jacobians[0]} = weight * relative.d_a;
    if (jacobians[1]) Eigen::Map<RowMajor3d>{jacobians[1]} = weight * relative.d_b;
    if (jacobians[2]) Eigen::Map<Eigen::Vector3d>{jacobians[2]} = -weight * step_.d_scale;
    if (jacobians[3]) {
      Eigen::Map<Eigen::Vector3d>{jacobians[3]} =
          -weight.leftCols<2>() * (travelled + error.head<2>());
    }
    return true;
  }

 private:
  PlanarStep step_;
  Eigen::Matrix3d whitening_;
};

// The pose in map of a place given in the frame of a node, with its derivatives by the node's pose
// and by the slip of the step on which it lies.
struct PlaceAtNode {
  Eigen::Vector3d place;  // x, y, yaw
  Eigen::Matrix3d d_node = Eigen::Matrix3d::Identity();
  Eigen::Vector3d d_slip = Eigen::Vector3d::Zero();
  PlaceAtNode(const double* node, double slip, const PlanarPose& at, const WheelWay& way) {
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(node[2]).toRotationMatrix();
    const Eigen::Vector2d turned = R * stretched(at, way, slip).p;
    place << node[0] + turned.x(), node[1] + turned.y(), node[2] + at.yaw;
    d_node(0, 2) = -turned.y();
    d_node(1, 2) = turned.x();
    d_slip.head<2>() = R * (std::exp(slip) * way.p);
  }
};

// [x - offset; y - lateral; yaw - (mirrored ? pi : 0)] over their standard deviations, with (x, y,
// yaw) the pose of the query's place in the frame of the memory's. Parameters: the two nodes and
// the two slips.
class PlanarRevisitFactor final : public ceres::SizedCostFunction<3, 3, 3, 1, 1> {
 public:
  PlanarRevisitFactor(const RevisitEdge& edge, double yaw_sigma)
      : edge_(edge),
        measured_(edge.offset_m, edge.lateral_m, edge.mirrored ? M_PI : 0.0),
        weight_(1 / edge.sigma_m, 1 / edge.lateral_sigma_m, 1 / yaw_sigma) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const PlaceAtNode memory(x[0], x[2][0], edge_.memory_at, edge_.memory_way);
    const PlaceAtNode query(x[1], x[3][0], edge_.query_at, edge_.query_way);
    const RelativePose relative(memory.place.data(), query.place.data());
    Eigen::Vector3d error = relative.value - measured_;
    error[2] = wrapped(error[2]);
    Eigen::Map<Eigen::Vector3d>{residuals} = weight_.cwiseProduct(error);
    if (!jacobians) return true;
    const auto W = weight_.asDiagonal();
    if (jacobians[0]) Eigen::Map<RowMajor3d>{jacobians[0]} = W * relative.d_a * memory.d_node;
    if (jacobians[1]) Eigen::Map<RowMajor3d>{jacobians[1]} = W * relative.d_b * query.d_node;
    if (jacobians[2]) {
      Eigen::Map<Eigen::Vector3d>{jacobians[2]} = W * relative.d_a * memory.d_slip;
    }
    if (jacobians[3]) {
      Eigen::Map<Eigen::Vector3d>{jacobians[3]} = W * relative.d_b * query.d_slip;
    }
    return true;
  }

 private:
  RevisitEdge edge_;
  Eigen::Vector3d measured_, weight_;
};

class ScalePrior final : public ceres::SizedCostFunction<1, 1> {
 public:
  ScalePrior(double scale, double sigma) : scale_(scale), weight_(1 / sigma) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (x[0][0] - scale_);
    if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
    return true;
  }

 private:
  double scale_, weight_;
};

}  // namespace gprodom
