// A measurement of your own in the estimator's window: a cost function of Ceres between named parts
// of the robot's state at one moment or two. docs/estimation.md, "Your own factors".
//
// This header alone needs Ceres: find_package(gprodom COMPONENTS factors), gprodom::factors.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

// A part of the state, as a parameter block of the cost function.
enum class StatePart {
  kAttitude,    // 4: unit quaternion w, x, y, z of R_odom_body
  kPosition,    // 3: of body in odom, m
  kVelocity,    // 3: of body in odom, m/s
  kGyroBias,    // 3: rad/s
  kAccelBias,   // 3: m/s^2
  kWheelScale,  // 1: reported over true distance
};

struct UserFactor {
  struct Block {
    std::size_t moment = 0;  // index into `times`
    StatePart part = StatePart::kPosition;
  };

  std::string name;           // of this kind of factor, in warnings and in the status
  std::vector<TimeNs> times;  // one moment or two, the earlier first
  std::vector<Block> blocks;  // one for each parameter block of `cost`, in its order

  // Residuals of unit variance, nine at most. It is called from the solver's thread. Data that it
  // shares with your thread must be thread-safe and constant, or a replay will differ.
  std::shared_ptr<const ceres::CostFunction> cost;
  // On the squared norm of the residuals; null: quadratic. Its slope must not be negative.
  std::shared_ptr<const ceres::LossFunction> loss;
};

}  // namespace gprodom
