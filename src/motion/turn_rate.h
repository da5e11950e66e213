// How the robot turns in a long gap of the IMU, as far as it can be known: its turn rate is
// correlated over a time, and this robot shows how large it is, over what time, and whether it
// turns to one side more than to the other while it moves, as on laps. docs/estimation.md, "Gaps of
// the IMU".
#pragma once

#include <deque>

#include "estimation/state_input.h"
#include "motion/history/sensor_history.h"

namespace gprodom {

class TurnRate {
 public:
  TurnRate();

  // Learns from an interval with an IMU. In a long gap, sets the turn of each step and its
  // variance. The wheel's distances are set; resting_m: what the wheel of a robot that stands tells
  // in the interval, one standard deviation.
  void complete(StateInput& input, TimeNs from, const Eigen::Vector3d& gyro_bias,
                const ImuHistory& imu, double resting_m);

  // Mean rate about body z (rad/s) over the state interval that ends at `to`.
  void learn(double rate, TimeNs to);

  // Turn rates at both ends of a gap, rad/s.
  struct Ends {
    double before, after;
  };
  // Turn (rad) from `from` to `to`, seconds after the begin of a gap of gap_s. moves: 0 to 1, how
  // much of the mean goes on there.
  double turn(double gap_s, Ends ends, double from, double to, double moves = 1.0) const;
  // rad^2, of the turn over the whole gap.
  double variance(double gap_s) const;

 private:
  struct Rate {
    TimeNs to;
    double rate;
  };
  // As learnt so far, an Ornstein-Uhlenbeck process.
  struct Process {
    double mean, mean_variance;  // rad/s; its square
    double variance;             // of the rate about its mean
    double correlation_s;
  };
  Process process() const;
  Process about(double mean) const;  // the process with this mean

  std::deque<Rate> recent_;  // of the last second
  // Sums over pairs of rates a second apart: squares and products about zero, and the rates.
  double square_, product_, count_;
  double sum_ = 0.0;
  double seconds_ = 0.0;  // that the pairs were learnt over
};

}  // namespace gprodom
