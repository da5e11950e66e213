// Whether the accelerometer's horizontal axes are those that are configured. The IMU may be turned
// about the up axis, or the sign of an axis may be wrong. Its accelerations then contradict a wheel
// that grips, and without this hypothesis that looks like slip. docs/estimation.md, "Online
// slip estimation".
#pragma once

#include <Eigen/Core>
#include <vector>

#include "motion/slip/slip_hypothesis.h"

namespace gprodom::slip {

class AccelerometerAxes {
 public:
  AccelerometerAxes();

  // Adds to one hypothesis, whose axes are as configured, the same with other axes.
  void branch(std::vector<Hypothesis>& hypotheses) const;

  // From the weights and states of all hypotheses.
  void learn(const std::vector<Hypothesis>& hypotheses);

  // Probability that the axes are not as configured.
  double wrong() const { return wrong_; }

  // Standard deviation of the error of a horizontal acceleration (forwards, left; m/s^2) that
  // nothing corrects.
  double error_sigma(const Eigen::Vector2d& acceleration) const;

 private:
  struct Kind {
    int kind;
    double share;          // of wrong_
    Eigen::Vector4d mean;  // row::kAxes
    Eigen::Matrix4d covariance;
  };

  double wrong_;
  std::vector<Kind> kinds_;
};

}  // namespace gprodom::slip
