// Multiple-hypothesis filter of slip that begins over seconds: l = ln(true distance / distance by
// the wheel) of each state interval, with its standard deviation. Sudden slips are SlipWatch's.
//
// A hypothesis says when the wheel gripped (l = 0), when its slip changed and when its slip was
// constant. It runs a Kalman filter over speed, tilt, biases, slip and the ground's decorrelation
// length. Its measurements: accelerations along the track, centripetal acceleration in bends
// (speed times turn rate), standstills, and the radar's coherence. A slip is detected seconds after
// it begins, so the estimates of the last intervals are revised each time. The hypotheses outlast
// gaps of the IMU. docs/estimation.md, "Online slip estimation".
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "estimation/graph/slip_model.h"
#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "motion/slip/accelerometer_axes.h"
#include "motion/slip/ground_noise.h"
#include "motion/slip/slip_block.h"
#include "motion/slip/slip_hypothesis.h"
#include "motion/slip/slip_share.h"
#include "motion/slip/unseen_slip.h"
#include "motion/slip/wheel_position.h"

namespace gprodom {

namespace slip {

// What is saved for the next run.
struct Learnt {
  SlipShare::Counts counts;
  LearntPosition position;
};

}  // namespace slip

class SlipBelief {
 public:
  explicit SlipBelief(const Config& config);

  // Forgets speed, attitude and slip; the next interval begins with the newest state's.
  void restart();

  // One state interval. newest: in effect, to begin with. rest: the IMU's noise at standstill.
  // driving_accel_density: as one second of driving shows it, m/s^2/sqrt(Hz); 0: not known yet.
  void advance(const StateInput& input, const StateResult& newest, const ImuNoise& rest,
               double driving_accel_density);

  // How far the radar says that the robot moved while the wheel counted wheel_m (reported, signed).
  void compare(const gpr::PathLength& path, double wheel_m);

  // Mean over the hypotheses for each of the last intervals with a wheel, newest last. Empty until
  // the first second is complete.
  std::vector<IntervalSlip> recent() const;

  // Variance of l in the oldest of the intervals of recent(), for the published covariance. Errors
  // of acceleration are correlated, so the measurements count less than in recent(). Nothing if
  // recent() is empty.
  std::optional<double> left() const;

  // Standard deviation of the error of the accelerations in steps (m/s^2) if the accelerometer's
  // axes are not as configured.
  double axes_error(const std::vector<MotionStep>& steps) const;

  // m, error of the wheel's distance over an interval, at least.
  void set_wheel_floor(double floor_m) { wheel_floor_ = floor_m; }

  const slip::WheelPosition& position() const { return position_; }
  const slip::SlipShare& share() const { return share_; }
  slip::Learnt learnt() const { return {share_.counts(), position_.learnt()}; }
  // Of an earlier run.
  void take_up(const slip::Learnt& earlier) {
    share_.take_up(earlier.counts);
    position_.resume(earlier.position);
  }

 private:
  struct Interval {
    TimeNs to;
    bool wheel;         // in use
    std::size_t block;  // its number
  };
  // residual: measurement less its prediction; H: derivative of the prediction by the state.
  struct Measured {
    slip::Vector H;
    double residual;
  };

  // Sums over the hypotheses of one interval, each with its probability to a power.
  struct Sums {
    double weight = 0.0, mean = 0.0, square = 0.0, slips = 0.0;
  };

  Sums sums(const Interval& interval, double power) const;
  void begin(const StateResult& newest);
  slip::Hypothesis first_hypothesis(const StateResult& newest) const;
  void resume(const StateResult& newest);
  void close();
  void branch(double block_s);
  void learn_share();
  void predict(slip::Hypothesis& h, bool rolls) const;
  void weigh(slip::Hypothesis& h) const;
  void weigh_standing(slip::Hypothesis& h) const;
  void weigh_wheel(slip::Hypothesis& h) const;
  Eigen::Vector2d errors(const slip::Hypothesis& h) const;
  Measured sideways(const slip::Hypothesis& h) const;
  void take_out_common_error();

  SlipModel model_;
  bool enabled_;
  slip::SlipShare share_;
  slip::UnseenSlip unseen_;
  double wheel_noise_, wheel_floor_;
  slip::WheelPosition position_;
  slip::AccelerometerAxes axes_;
  std::size_t lag_;  // intervals that recent() gives
  std::vector<slip::Hypothesis> hypotheses_;
  std::deque<Interval> intervals_;
  // Heading by the gyro alone; tilt by the hypotheses.
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
  slip::Block block_;
  std::size_t blocks_ = 0;  // before it
  double scale_ = 1.0;      // of the wheel, that rows are relative to
  ImuNoise rest_;
  double way_m_ = 0.0;
  bool usable_before_ = true;  // the wheel, in the last interval
  bool ground_known_ = false;
  int unit_ = 0;  // of the lengths that the ground is known in
  slip::GroundNoise ground_;
};

}  // namespace gprodom
