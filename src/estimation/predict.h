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

// The distance that the contact point of the wheel has moved since a state, along the track, as
// propagated by the IMU.
struct PredictedWay {
  TimeNs time = 0;                              // its end
  double distance_m = 0.0;                      // signed
  Eigen::Matrix<double, kStateDim, 1> d_state;  // by the chart's error of the state
  // Of the preintegrated noise: variance of the distance, and its covariance with the noise of
  // position and velocity at `time`, in odom.
  double noise_m2 = 0.0;
  Eigen::Vector3d with_p, with_v;
};

PredictedWay predicted_way(const NavState& state, const ImuPreintegration& since,
                           const Eigen::Vector3d& contact_body, double gravity_mps2);

// The wheel's distance over the same time.
struct WheelWaySince {
  double reported_m = 0.0;  // signed
  double sigma_m = 0.0;     // of the distance, scale known
};

// Kalman update of predict()'s estimate, some time after the way's end, with the wheel's distance.
// It corrects the movement since the state, not the state: an error of the scale has moved the
// state by its share of all the way, and half a second of wheel is too little to correct that.
// Weighed by Cauchy's kernel as the wheel's increments in the window are; threshold 0: in full.
void take_wheel(const NavState& state, const StateMatrix& covariance,
                const ImuPreintegration& since, double gravity_mps2, const PredictedWay& way,
                const WheelWaySince& wheel, double robust_threshold, OdometryEstimate& estimate);

}  // namespace gprodom
