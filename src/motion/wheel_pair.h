// Left and right wheels over the intervals between states. They are calibrated against the gyro,
// replace it in a gap of the IMU, and show which side slips.
#pragma once

#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "motion/history/sensor_history.h"
#include "motion/turn_calibration.h"

namespace gprodom {

enum class SlippingSide { kNone, kLeft, kRight };

class WheelPair {
 public:
  explicit WheelPair(const WheelConfig& config);

  // false: the difference of the sides jumped (WheelHistory::insert).
  bool insert(const WheelsSample& sample);
  void forget_before(TimeNs time);
  bool received() const { return received_; }  // any sample so far
  // Unsigned path (m) of each side relative to the middle; 0 without samples.
  double path(TimeNs from, TimeNs to) const { return 0.5 * difference_.path(from, to); }
  // m/sqrt(m), noise of the sides' mean; 0 while it has not been learnt.
  double middle_noise() const;
  // m, error of one side's distance over any stretch.
  void set_floor(double floor_m) { calibration_.set_floor(floor_m); }

  // Adds to `input` what both sides show about the interval from `from` to a new state. Call in
  // time order. `newest`: the newest solved state. `wheel`: the history of the mean. ground_m:
  // signed distance by the published velocity, if that is known.
  void complete(StateInput& input, TimeNs from, const NavState& newest, const WheelHistory& wheel,
                std::optional<double> ground_m);

  SlippingSide slipping() const { return slipping_; }  // in the last interval
  const TurnCalibration& calibration() const { return calibration_; }
  // Before the first sample.
  void resume(const LearntTurn& learnt) { calibration_.resume(learnt); }
  // Nothing without samples, or if the difference of the sides does not turn the robot.
  std::optional<LearntTurn> learnt() const;

 private:
  struct Step {
    PairMotion motion;
    double turned_rad;  // by the gyro
  };

  std::optional<std::vector<Step>> steps_of(const StateInput& input, TimeNs from,
                                            const Eigen::Vector3d& gyro_bias,
                                            const WheelHistory& wheel, bool across_gaps) const;
  void replace_gyro(StateInput& input, const std::vector<Step>& steps);
  // One interval or several in a row; ground_m by the published velocity, in the wheels' units.
  struct Stretch {
    PairMotion motion;
    GyroTurn turn;
    double ground_m = 0.0, seconds = 0.0;
  };

  void interrupt();
  std::pair<double, double> error_of(const Stretch& stretch) const;
  SlippingSide judge(const Stretch& whole) const;
  bool rules_out_common_slip() const;
  void use_other_side(StateInput& input, const std::vector<Step>& steps) const;

  WheelConfig config_;
  WheelHistory difference_;
  TurnCalibration calibration_;
  std::deque<Stretch> recent_;  // intervals in a row, oldest first
  SlippingSide slipping_ = SlippingSide::kNone;
  bool received_ = false;
  PairMotion in_gap_;  // since the gap of the IMU began
};

}  // namespace gprodom
