// How the robot moved from one state to the next, as its sensors together tell it.
//
// The judge keeps the last seconds of IMU, wheel and radar, and it alone weighs them against each
// other: does the robot stand, does the wheel slip, has the gyro bias moved, which noise holds,
// what is a decorrelation length in metres. It is asked one question for each new state (judge()),
// and follows what is published, against which a slip shows (follow()).
#pragma once

#include <optional>
#include <vector>

#include "estimation/initializer.h"
#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/coherence_scale.h"
#include "motion/drive_noise.h"
#include "motion/sensor_history.h"
#include "motion/slip/slip_belief.h"
#include "motion/slip_watch.h"
#include "motion/standstill.h"
#include "motion/wheel_pair.h"

namespace gprodom {

class MotionJudge {
 public:
  explicit MotionJudge(const Config& config);

  // Body axes. false: there is one of that stamp already, and this one is dropped.
  bool add(const ImuSample& sample);

  // false: the distance jumped further than wheel.max_speed allows (WheelHistory::insert). A wheel
  // that is not enabled is not listened to.
  bool add(const WheelSample& sample);
  bool add(const WheelsSample& sample);  // their mean is the wheel

  // From another process, in effect at once. Dropped where too many wait for a first state.
  void add_external(Displacement displacement);

  // What the radar front end says of motion, as it is published: lengths in metres, a standstill as
  // a distance of 0. Not of a Sight.
  Displacement in_metres(const gpr::Finding& finding);

  // The same once it is in effect, with what in_metres() made of it. Ignored where not valid.
  void add_radar(const gpr::Finding& finding, const Displacement& in_metres);

  // What the radar front end says of how well it sees motion.
  void add_sight(const gpr::Sight& sight);

  // Slower motion may pass the radar unseen, m/s: two standard deviations on the safe side, once
  // that is known.
  std::optional<double> unseen_speed() const;
  static constexpr double kUnseenAtFirst = 0.05;  // m/s; of most grounds it is less

  // The first state and its noise, from the last initializer.duration of standstill, or, of a robot
  // that has been on the move for some seconds, from those; or why not. Forgets the IMU's samples
  // before that.
  Initialization initialize();

  // The first state, from the initialiser or from a run before, with the IMU's noise at standstill
  // (or, after a start on the move, what is known of it).
  void begin(const StateResult& first, const InitialState& initial);

  // Of a run before: the wheel's count at a time before the first sample. It is believed to have
  // counted on meanwhile.
  void resume_wheel(const WheelSample& sample) { wheel_.resume(sample); }
  void resume_pair(const LearntTurn& learnt) { pair_.resume(learnt); }
  void forget_wheel() { wheel_ = WheelHistory(config_.wheel.max_speed); }

  // A newer state is in effect. Forgets what no later question reaches back to.
  void adopt(const StateResult& newest);

  // The question: what is known of the interval from the last state asked about to the one at `to`?
  // Each displacement is handed out once, with the first state that it does not reach beyond.
  StateInput judge(TimeNs to);

  // An estimate is published: sets its flags, kNoRadar excepted. true: the wheel begins to slip.
  bool follow(OdometryEstimate& estimate);

  // Of the IMU between two times: what its samples show where that is more than at standstill
  // (imu.adaptive_noise), else as at standstill.
  ImuNoise noise(TimeNs from, TimeNs to) const;
  const ImuNoise& noise_at_standstill() const { return noise_at_standstill_; }

  const ImuHistory& imu() const { return imu_; }
  const WheelHistory& wheel() const { return wheel_; }
  const WheelPair& pair() const { return pair_; }
  // s, behind the IMU; 0 where none shows.
  double wheel_delay_s() const;

 private:
  AtRest at_rest() const;
  void learn_rest(TimeNs to);
  void compare_with_wheel(const gpr::PathLength& path);
  bool imu_silent(TimeNs from, TimeNs to) const;
  std::vector<Displacement> take_displacements(TimeNs to);
  bool enters_estimate(const Displacement& displacement) const;
  void forget_old_standing();
  std::int32_t flags() const;

  const Config config_;
  const TimeNs state_period_, imu_gap_, lag_;

  ImuHistory imu_;
  WheelHistory wheel_;
  WheelPair pair_;
  TimeNs imu_now_ = 0, wheel_now_ = 0;           // newest stamps
  std::vector<gpr::Standstill> radar_standing_;  // newest last
  std::vector<Displacement> displacements_;      // not handed out yet

  TimeNs first_imu_ = 0;
  ImuNoise noise_at_standstill_;
  bool rest_known_ = false;         // that noise is of a standstill that was seen
  double resting_wheel_mps_ = 0.0;  // what the wheel shows at rest nevertheless
  double moving_accel_ = 0.0;       // m/s^2/sqrt(Hz), of late while the wheel turned
  DriveNoise drive_noise_;
  StateResult newest_;   // in effect
  TimeNs asked_to_ = 0;  // the newest state asked about
  SlipWatch slip_;
  SlipBelief slip_belief_;
  BiasWatch bias_watch_;
  CoherenceScale coherence_;
  CoherenceScale sight_;          // m/s, the least that the radar sees
  TimeNs speed_known_after_ = 0;  // until then the wheel is the only witness of the speed
  TimeNs wheel_doubted_ = 0;      // end of the last state interval without a wheel that can be used
};

}  // namespace gprodom
