// Propagation of a state by the IMU alone.
#pragma once

#include <Eigen/Core>

#include "estimation/imu_preintegration.h"
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

}  // namespace gprodom
