// What a run has learnt: the wheel's scale, how often it slips, the turn calibration of left and
// right wheels, and the mounting of the IMU.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>

#include "gprodom/config.h"
#include "motion/slip/slip_belief.h"
#include "motion/turn_calibration.h"

namespace gprodom {

// The configured wheel as text. If the text has changed, the wheel is another one, and nothing that
// was learnt applies to it.
std::string wheel_setting(const Config& config);
// The same for the configured pair of wheels.
std::string pair_setting(const Config& config);

struct SavedWheel {
  double scale = 1.0;   // reported over true distance
  double sigma = 0.02;  // standard deviation
  std::string setting;  // wheel_setting() when it was learnt
};

// How much of the path the wheel slipped, and where it is.
struct SavedSlip {
  slip::Learnt learnt;
  std::string setting;  // wheel_setting() when it was learnt
};

struct SavedPair {
  LearntTurn learnt;
  std::string setting;  // pair_setting() when it was learnt
};

// How the IMU is mounted, as a drive has shown it.
struct LearntMounting {
  Eigen::Quaterniond q_body_imu = Eigen::Quaterniond::Identity();
  double yaw_sigma = 0.0;  // rad
};

std::string to_bytes(const SavedWheel& wheel);
std::string to_bytes(const SavedSlip& slip);
std::string to_bytes(const SavedPair& pair);
std::string to_bytes(const LearntMounting& mounting);

// name: of the file, for errors. Throw FileError where it is not a whole one that makes sense.
SavedWheel saved_wheel_from(const std::string& name, std::string_view bytes);
SavedSlip saved_slip_from(const std::string& name, std::string_view bytes);
SavedPair saved_pair_from(const std::string& name, std::string_view bytes);
LearntMounting saved_mounting_from(const std::string& name, std::string_view bytes);

}  // namespace gprodom
