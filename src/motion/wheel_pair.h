// Left and right wheels over the intervals between states: they learn from the gyro, stand in for
// it while it is silent, and tell which side slips.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "motion/sensor_history.h"
#include "motion/turn_calibration.h"

namespace gprodom {

enum class SlippingSide { kNone, kLeft, kRight };

class WheelPair {
 public:
  explicit WheelPair(const WheelConfig& config);

  // false where the difference of the sides jumped further than wheel.max_speed allows.
  bool insert(const WheelsSample& sample);
  void forget_before(TimeNs time);
  bool heard() const { return heard_; }
  // Unsigned way (m) of each side about the middle; 0 where there are no samples.
  double path(TimeNs from, TimeNs to) const { return 0.5 * difference_.path(from, to); }
  // m/sqrt(m), of the sides' mean; 0 where they have not shown it.
  double middle_noise() const;

  // Completes what is known of the interval from `from` to a new state; intervals come in time
  // order. `newest`: the newest state that is solved. `wheel`: the history of the mean. ground_m:
  // how far the robot came by the published velocity, where that is known (m, signed).
  void complete(StateInput& input, TimeNs from, const NavState& newest, const WheelHistory& wheel,
                std::optional<double> ground_m);

  SlippingSide slipping() const { return slipping_; }  // over the last interval completed
  const TurnCalibration& calibration() const { return calibration_; }
  // Before the first sample.
  void resume(const LearntTurn& learnt) { calibration_.resume(learnt); }
  std::optional<LearntTurn> learnt() const;  // where it is heard, and its sides turn the robot

 private:
  struct Step {
    PairMotion motion;
    double turned_rad;  // by the gyro
  };

  std::optional<std::vector<Step>> steps_of(const StateInput& input, TimeNs from,
                                            const Eigen::Vector3d& gyro_bias,
                                            const WheelHistory& wheel, bool across_gaps) const;
  void stand_in(StateInput& input, const std::vector<Step>& steps);
  // An interval, or some in a row; ground_m by the published velocity, as the wheels report it.
  struct Stretch {
    PairMotion motion;
    GyroTurn turn;
    double ground_m = 0.0, seconds = 0.0;
  };

  void interrupt();
  SlippingSide judge(const Stretch& whole) const;
  bool vouches() const;
  void go_by_the_other(StateInput& input, const std::vector<Step>& steps) const;

  WheelConfig config_;
  WheelHistory difference_;
  TurnCalibration calibration_;
  std::deque<Stretch> recent_;  // without a break, oldest first
  SlippingSide slipping_ = SlippingSide::kNone;
  bool heard_ = false;
  PairMotion in_gap_;  // since the IMU fell silent
};

}  // namespace gprodom
