// The state after something was found wrong.
#include "estimation/revised_state.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "support/derivative.h"

namespace gprodom {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

NavState some_state() {
  NavState x;
  x.q_odom_body = Quaterniond(AngleAxisd(0.8, Vector3d(0.1, 0.05, 1).normalized()));
  x.p_odom = {3, -2, 0.5};
  x.v_odom = {0.6, 0.4, 0.02};
  x.gyro_bias = {0.01, -0.02, 0.005};
  x.accel_bias = {0.03, 0.01, -0.02};
  return x;
}

const Matrix3d kTurn =
    (AngleAxisd(1.9, Vector3d::UnitZ()) * AngleAxisd(0.1, Vector3d::UnitX())).toRotationMatrix();

TEST(TurnedAxes, TheImuSeesTheSameAndTheHeadingStays) {
  const NavState x = some_state();
  const NavState y = with_turned_axes({x, StateMatrix::Identity()}, kTurn).state;
  // Gravity in the axes of the IMU.
  const Vector3d up_old = x.q_odom_body.conjugate() * Vector3d::UnitZ(),
                 up_new = y.q_odom_body.conjugate() * Vector3d::UnitZ();
  EXPECT_LT((up_new - kTurn * up_old).norm(), 1e-12);
  const Vector3d ahead_old = x.q_odom_body * Vector3d::UnitX(),
                 ahead_new = y.q_odom_body * Vector3d::UnitX();
  EXPECT_NEAR(std::atan2(ahead_new.y(), ahead_new.x()), std::atan2(ahead_old.y(), ahead_old.x()),
              1e-12);
  EXPECT_EQ(y.p_odom, x.p_odom);
  EXPECT_EQ(y.v_odom, x.v_odom);
  EXPECT_LT((y.gyro_bias - kTurn * x.gyro_bias).norm(), 1e-15);
}

// The covariance is J P J^T; J against numeric derivatives, of all but the heading's own change by
// a tilt, which is of the second order in the slope.
TEST(TurnedAxes, CovarianceFollowsTheDerivatives) {
  NavState x = some_state();
  x.q_odom_body = Quaterniond(AngleAxisd(0.8, Vector3d::UnitZ()));
  const Matrix3d turn = AngleAxisd(1.9, Vector3d::UnitZ()).toRotationMatrix();
  const CarriedState at = with_turned_axes({x, StateMatrix::Identity()}, turn);
  const StateMatrix J = numeric_jacobian(kStateDim, 1e-4, [&](const StateVector& d) {
    return local(at.state, with_turned_axes({retract(x, d), StateMatrix::Identity()}, turn).state);
  });
  StateMatrix P = StateMatrix::Identity();
  P.diagonal() << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16;
  const StateMatrix numeric = J * P * J.transpose();
  EXPECT_LT((with_turned_axes({x, P}, turn).covariance - numeric).norm(), 1e-5 * numeric.norm());
}

}  // namespace
}  // namespace gprodom
