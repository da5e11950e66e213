// What the wheel messages of ROS 1 and ROS 2 say, as the wheel samples that the estimator takes.
// Nothing that is not finite stays in what is summed up here: the sample of a message that has such
// a value is not finite either, so that the estimator refuses and counts it, and the next is right.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/types.h"

namespace gprodom::ros_shared {

// The wheel's distance from the poses that its driver integrates: the chord of each step, projected
// on the heading halfway.
class WheelOdometry {
 public:
  WheelSample add(TimeNs time, const Eigen::Vector3d& position,
                  const Eigen::Quaterniond& orientation);

 private:
  std::optional<Eigen::Vector3d> position_;
  Eigen::Quaterniond orientation_ = Eigen::Quaterniond::Identity();
  double distance_m_ = 0.0;
};

// The integral of a rate over time, by the trapezoidal rule.
class Integral {
 public:
  // Not finite where `rate` or what it would add is not; such a rate has no effect on later ones.
  double add(TimeNs time, double rate);

 private:
  std::optional<TimeNs> last_;
  double rate_ = 0.0, sum_ = 0.0;
};

// Left and right wheels, track_m apart, of a middle that was driven and an angle (rad) turned.
WheelsSample to_wheels(const WheelSample& middle, double turned_rad, double track_m);

// The joint's angle (rad) times the wheel's radius (m); nothing if the message lacks the joint.
// `names` and `positions` are those of sensor_msgs/JointState.
std::optional<WheelSample> to_sample(TimeNs time, const std::vector<std::string>& names,
                                     const std::vector<double>& positions, const std::string& joint,
                                     double radius_m);

// The same of two sides, each the mean of its joints.
std::optional<WheelsSample> to_sample(TimeNs time, const std::vector<std::string>& names,
                                      const std::vector<double>& positions,
                                      const std::vector<std::string>& left,
                                      const std::vector<std::string>& right, double radius_m);

// "front_left,rear_left": the names between the commas.
std::vector<std::string> names_by_commas(const std::string& list);

}  // namespace gprodom::ros_shared
