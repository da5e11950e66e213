// Multiple-hypothesis filter of slip that begins over seconds: l = ln(true distance / distance by
// the wheel) of each state interval, with its standard deviation. Sudden slips are SlipWatch's.
//
// A hypothesis says when the wheel gripped (l = 0), when its slip changed and when its slip was
// constant. It runs a Kalman filter over speed, tilt, biases, slip and the ground's decorrelation
// length. Its measurements: accelerations along the track, centripetal acceleration in bends
// (speed times turn rate), standstills, and the radar's coherence. A slip is detected seconds after
// it begins, so the estimates of the last intervals are revised each time. The hypotheses outlast
// gaps of the IMU. docs/estimation.md, "Slip as it goes".
#pragma once

#include <deque>
#include <vector>

#include "estimation/graph/slip_model.h"
#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "motion/slip/ground_noise.h"
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
  // Of a late wheel, input.steps are those of as much earlier (LateWheel).
  void advance(const StateInput& input, const StateResult& newest, const ImuNoise& rest,
               double driving_accel_density);

  // How far the radar says that the robot moved while the wheel counted wheel_m (reported, signed).
  void compare(const gpr::PathLength& path, double wheel_m);

  // Mean over the hypotheses for each of the last intervals with a wheel, newest last. Empty until
  // the first second is complete.
  std::vector<IntervalSlip> recent() const;

  const slip::SlipShare& share() const { return share_; }
  // Of an earlier run.
  void take_up(const slip::SlipShare::Counts& earlier) { share_.take_up(earlier); }

 private:
  struct Interval {
    TimeNs to;
    bool wheel;         // in use
    std::size_t block;  // its number
  };
  // Sums over one second. Measurements are compared over that time: noise from sample to sample is
  // not known as well as that of seconds, and would look like slip.
  struct Block {
    double dt = 0, wheel_m = 0, turned = 0;
    double turned_m = 0;  // by which the body moves more than the wheel, beside which it turns
    int intervals = 0;
    double gained = 0,
           behind_m = 0;  // m/s; m, by which the way is less than that at the last speed
    double left = 0;      // m/s; less the part of `gained` that turned
    Eigen::Vector2d forwards = Eigen::Vector2d::Zero(), leftwards = Eigen::Vector2d::Zero();  // s
    Eigen::Vector3d rates = Eigen::Vector3d::Zero();  // rad, body
    double wheel_variance = 0;                        // m^2
    ImuNoise noise;
    double speed_variance = 0, tilt_variance = 0;  // m^2/s^2, rad^2: by the IMU's noise
    bool standing = false, wheel = true;
    bool gap = false;  // of the IMU
  };

  void begin(const StateResult& newest);
  slip::Hypothesis first_hypothesis(const StateResult& newest) const;
  void resume(const StateResult& newest);
  void take_in(const StateInput& input);
  void close();
  void branch(double block_s);
  void learn_share();
  void predict(slip::Hypothesis& h, bool rolls) const;
  void weigh(slip::Hypothesis& h) const;
  void take_out_common_error();

  SlipModel model_;
  bool enabled_;
  slip::SlipShare share_;
  slip::UnseenSlip unseen_;
  double wheel_noise_, wheel_floor_;
  std::size_t lag_;  // intervals that recent() gives
  std::vector<slip::Hypothesis> hypotheses_;
  std::deque<Interval> intervals_;
  Eigen::Quaterniond q_;  // heading by the gyro alone; tilt by the hypotheses
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
  Block block_;
  std::size_t blocks_ = 0;  // before it
  double scale_ = 1.0;      // of the wheel, that rows are relative to
  ImuNoise rest_;
  double way_m_ = 0.0;
  bool usable_before_ = true;  // the wheel, in the last interval
  bool ground_known_ = false;
  slip::GroundNoise ground_;
};

}  // namespace gprodom
