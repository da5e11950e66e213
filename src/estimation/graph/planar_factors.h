// Residuals of the pose graph, whitened, with analytic derivatives.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "estimation/graph/pose_graph.h"
#include "estimation/planar_geometry.h"

namespace gprodom {

// Pose of node b in the frame of node a, with its derivatives.
struct RelativePose {
  Eigen::Vector3d value;  // x, y, yaw; m, rad
  Eigen::Matrix3d d_a, d_b;
  RelativePose(const PlanarPose& a, const PlanarPose& b) {
    const Eigen::Matrix2d RT = Eigen::Rotation2Dd(-a.yaw).toRotationMatrix();
    const Eigen::Vector2d local = RT * (b.p - a.p);
    value << local, wrapped(b.yaw - a.yaw);
    d_a << -RT, Eigen::Vector2d(local.y(), -local.x()), 0, 0, -1;
    d_b << RT, Eigen::Vector2d::Zero(), 0, 0, 1;
  }
};

// Three residuals and their derivatives by the (x, y, yaw) of two nodes and by two numbers.
struct PlanarResidual {
  Eigen::Vector3d value;
  Eigen::Matrix<double, 3, 8> J;
};

// W U ([x, y, yaw](a to b) - [e^l measured (x, y); measured yaw] - d_scale (s - s_measured)), with
// s the wheel's scale, l the slip of the step, and U = diag(e^-l, e^-l, 1): the error is in metres
// by the wheel, so that a track which is smaller as a whole does not have smaller errors. m, rad.
// Derivatives by a, b, s, l.
inline PlanarResidual step_residual(const WhitenedStep& step, const PlanarPose& a,
                                    const PlanarPose& b, double scale, double slip) {
  const PlanarStep& odometry = step.odometry;
  const RelativePose relative(a, b);
  const double longer = std::exp(slip);
  const Eigen::Vector2d travelled = longer * odometry.measured.p;
  Eigen::Vector3d error = relative.value - odometry.d_scale * (scale - odometry.scale);
  error.head<2>() -= travelled;
  error[2] = wrapped(error[2] - odometry.measured.yaw);
  const Eigen::Matrix3d weight =
      step.whitening * Eigen::Vector3d(1 / longer, 1 / longer, 1.0).asDiagonal();
  PlanarResidual residual;
  residual.value = weight * error;
  residual.J << weight * relative.d_a, weight * relative.d_b, -weight * odometry.d_scale,
      -weight.leftCols<2>() * (travelled + error.head<2>());
  return residual;
}

// W [x - x_0; y - y_0; yaw - yaw_0] of the first node. Its derivative by (x, y, yaw) is W.
inline Eigen::Vector3d prior_residual(const FirstPrior& prior, const PlanarPose& first) {
  Eigen::Vector3d error;
  error << first.p - prior.pose.p, wrapped(first.yaw - prior.pose.yaw);
  return prior.whitening * error;
}

// The pose in map of a place given in the frame of a node, with its derivatives by the node's pose
// and by the slip of the step on which it lies.
struct PlaceAtNode {
  PlanarPose place;
  Eigen::Matrix3d d_node = Eigen::Matrix3d::Identity();
  Eigen::Vector3d d_slip = Eigen::Vector3d::Zero();
  PlaceAtNode(const PlanarPose& node, double slip, const PlanarPose& at, const WheelWay& way) {
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(node.yaw).toRotationMatrix();
    const Eigen::Vector2d turned = R * stretched(at, way, slip).p;
    place = {node.p + turned, node.yaw + at.yaw};
    d_node(0, 2) = -turned.y();
    d_node(1, 2) = turned.x();
    d_slip.head<2>() = R * (std::exp(slip) * way.p);
  }
};

// [x - offset; y - lateral; yaw - (mirrored ? pi : 0)] over their standard deviations, with (x, y,
// yaw) the pose of the query's place in the frame of the memory's. Derivatives by the nodes of
// memory and query, and by the slips of their steps.
inline PlanarResidual revisit_residual(const RevisitEdge& edge, double yaw_sigma,
                                       const PlanarPose& memory_node, const PlanarPose& query_node,
                                       double memory_slip, double query_slip) {
  const PlaceAtNode memory(memory_node, memory_slip, edge.memory_at, edge.memory_way);
  const PlaceAtNode query(query_node, query_slip, edge.query_at, edge.query_way);
  const RelativePose relative(memory.place, query.place);
  const Eigen::Vector3d measured(edge.offset_m, edge.lateral_m, edge.mirrored ? M_PI : 0.0);
  const Eigen::Vector3d weight(1 / edge.sigma_m, 1 / edge.lateral_sigma_m, 1 / yaw_sigma);
  Eigen::Vector3d error = relative.value - measured;
  error[2] = wrapped(error[2]);
  PlanarResidual residual;
  residual.value = weight.cwiseProduct(error);
  residual.J << relative.d_a * memory.d_node, relative.d_b * query.d_node,
      relative.d_a * memory.d_slip, relative.d_b * query.d_slip;
  residual.J = weight.asDiagonal() * residual.J;
  return residual;
}

// Of a fix: L^-1 (place of the antenna in map - p), with L L^T the covariance, in standard
// deviations; and the heading less that of the fix over its standard deviation, if it has one.
// Derivatives by the (x, y, yaw) of the node and by the slip of its step.
struct FixResidual {
  Eigen::Vector2d value;
  Eigen::Matrix<double, 2, 4> J;
  double heading = 0.0;
  FixResidual(const FixEdge& fix, const PlanarPose& node, double slip) {
    const PlaceAtNode antenna(node, slip, fix.at, fix.way);
    const Eigen::LLT<Eigen::Matrix2d> root(fix.covariance);
    value = root.matrixL().solve(antenna.place.p - fix.p);
    J << antenna.d_node.topRows<2>(), antenna.d_slip.head<2>();
    J = root.matrixL().solve(J).eval();
    if (fix.yaw_sigma > 0.0) heading = wrapped(antenna.place.yaw - fix.yaw) / fix.yaw_sigma;
  }
};

}  // namespace gprodom
