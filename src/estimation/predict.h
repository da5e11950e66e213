// Propagation of a state by the IMU, and what the wheel says since then.
#pragma once

#include <Eigen/Core>

#include "estimation/increments/imu_preintegration.h"
#include "estimation/nav_state.h"
#include "gprodom/types.h"

namespace gprodom {

// Without covariance.
NavState propagate(const NavState& state, const ImuPreintegration& since, double gravity_mps2);

// Rows: plain errors phi, dp, dv of the propagated state, R_true = Exp(phi) R, p_true = p + dp,
// v_true = v + dv. Columns: the chart's error of `state`.
using PropagationJacobian = Eigen::Matrix<double, 9, kStateDim>;
PropagationJacobian propagation_jacobian(const NavState& state, const ImuPreintegration& since,
                                         double gravity_mps2);

// With covariance: the estimate between two solves.
OdometryEstimate predict(const NavState& state, const StateMatrix& covariance,
                         const ImuPreintegration& since, double gravity_mps2);

// The way of the wheel's contact point since a state, as propagated by the IMU: forwards (signed),
// to the left and upwards. Each is the integral of a velocity in body axes, so in a bend it is that
// along the path.
struct PredictedWay {
  TimeNs time = 0;         // its end
  Eigen::Vector3d p_odom;  // of the body there
  Eigen::Matrix3d R_odom_body;
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  double turned_rad = 0.0;  // of the body's x axis, 0 or more
  // By the chart's error of the state.
  Eigen::Matrix<double, kStateDim, 3> d_state = Eigen::Matrix<double, kStateDim, 3>::Zero();
  // Of the preintegrated noise: covariance of the way, and that of position and velocity at its
  // end, in odom (rows), with it.
  Eigen::Matrix3d noise_m2 = Eigen::Matrix3d::Zero(), with_p = Eigen::Matrix3d::Zero(),
                  with_v = Eigen::Matrix3d::Zero();
};

// That of no movement yet.
inline PredictedWay way_begins(const NavState& state) {
  return {state.time, state.p_odom, state.R_odom_body()};
}

// `before` and the step of the IMU that has been added to `since` since then.
PredictedWay way_further(const PredictedWay& before, const NavState& state,
                         const ImuPreintegration& since, const Eigen::Vector3d& contact_body,
                         double gravity_mps2);

// What the wheel says of the same way.
struct WheelWaySince {
  Eigen::Vector3d moved_m;  // forwards as reported; a wheel moves neither sideways nor upwards
  Eigen::Vector3d sigma_m;  // scale known
};

// Kalman update of predict()'s estimate, some time after the way's end, with the wheel's way.
// It corrects the movement since the state, not the state: an error of the scale has moved the
// state by its share of all the way, and half a second of wheel is too little to correct that.
// The distance is weighed by Cauchy's kernel as the wheel's increments in the window are; threshold
// 0: in full.
void take_wheel(const NavState& state, const StateMatrix& covariance,
                const ImuPreintegration& since, double gravity_mps2, const PredictedWay& way,
                const WheelWaySince& wheel, double robust_threshold, OdometryEstimate& estimate);

}  // namespace gprodom
