// A user's factor through the whole estimator: when it is accepted, and its effect on the pose.
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gprodom/odometry.h"
#include "gprodom/user_factor.h"
#include "pipeline/test_drive.h"
#include "support/told.h"

namespace gprodom {
namespace {

// Residual: the height of the robot above the origin, with a standard deviation of 1 mm.
class Height final : public ceres::SizedCostFunction<1, 3> {
 public:
  explicit Height(double metres) : metres_(metres) {}
  bool Evaluate(double const* const* p, double* r, double** J) const override {
    r[0] = (p[0][2] - metres_) / 1e-3;
    if (J && J[0]) {
      J[0][0] = J[0][1] = 0.0;
      J[0][2] = 1e3;
    }
    return true;
  }

 private:
  double metres_;
};

UserFactor height_at(double seconds, double metres) {
  UserFactor factor;
  factor.name = "height";
  factor.times = {from_seconds(seconds)};
  factor.blocks = {{0, StatePart::kPosition}};
  factor.cost = std::make_shared<Height>(metres);
  return factor;
}

// Stands for three seconds, then drives straight on.
class Drive {
 public:
  void go_on_until(double end) {
    for (; seconds < end - 1e-9; seconds += 0.01, ++i_) {
      const double speed = std::fmin(std::fmax(seconds - 1003.0, 0.0), 0.5);
      ImuSample imu = resting_imu(from_seconds(seconds), i_);
      if (seconds > 1003.0 && seconds < 1003.5) imu.acceleration.x() += 1.0;
      way_m_ += speed * 0.01;
      odometry.add(imu);
      odometry.add(WheelSample{imu.time, way_m_});
      Outputs out = odometry.step();
      if (!out.odometry.empty()) newest = out.odometry.back();
      if (!out.status.empty()) status = out.status.back();
    }
  }

  Odometry odometry{without_radar()};
  double seconds = 1000.0;
  OdometryEstimate newest;
  Status status;

 private:
  int i_ = 0;
  double way_m_ = 0.0;
};

TEST(AddFactor, MovesThePoseAndIsCountedInTheStatus) {
  Drive drive;
  drive.go_on_until(1010.0);
  EXPECT_LT(std::abs(drive.newest.p_odom_body.z()), 0.02);
  for (double t = 1010.0; t < 1012.0; t += 0.1) {
    EXPECT_EQ(drive.odometry.add_factor(height_at(t + 0.03, 0.1)), "");
    drive.go_on_until(t + 0.1);
  }
  drive.go_on_until(1013.5);  // past the status of the second in which the last was used
  EXPECT_NEAR(drive.newest.p_odom_body.z(), 0.1, 0.02);
  EXPECT_EQ(value_of(drive.status, "factors.used"), 20);
}

TEST(AddFactor, IsRefusedOutsideTheLag) {
  Drive drive;
  EXPECT_EQ(drive.odometry.add_factor(height_at(1000.0, 0.0)), "the estimator has not started");
  drive.go_on_until(1010.0);
  EXPECT_EQ(drive.odometry.add_factor(height_at(1003.0, 0.0)),
            "older than the window (smoother.lag)");
  EXPECT_EQ(drive.odometry.add_factor(height_at(1006.0, 0.0)), "");
  EXPECT_EQ(drive.odometry.add_factor(height_at(1020.0, 0.0)), "too far ahead of the IMU");
  UserFactor factor = height_at(1009.0, 0.0);
  factor.blocks[0].part = StatePart::kAttitude;
  EXPECT_NE(drive.odometry.add_factor(factor), "");
}

}  // namespace
}  // namespace gprodom
