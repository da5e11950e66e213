// How the robot moved from one state to the next, according to all its sensors.
//
// The judge keeps the last seconds of IMU, wheel and radar, and compares them with each other: does
// the robot stand, does the wheel slip, has the gyro bias changed, which noise applies, how long is
// a decorrelation length in metres. judge() is called once for each new state. follow() is called
// with each published estimate, because slip shows as a difference from it.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "estimation/initializer.h"
#include "estimation/predict.h"
#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/coherence_scale.h"
#include "motion/drive_noise.h"
#include "motion/history/sensor_history.h"
#include "motion/immobilised.h"
#include "motion/pair_slip.h"
#include "motion/rest/rest_levels.h"
#include "motion/rest/standstill.h"
#include "motion/rest/wheel_tick.h"
#include "motion/slip/slip_belief.h"
#include "motion/slip_watch.h"
#include "motion/turn_rate.h"
#include "motion/wheel_gap.h"
#include "motion/wheel_pair.h"

namespace gprodom {

class MotionJudge {
 public:
  explicit MotionJudge(const Config& config);

  // Body axes. false: the sample is dropped, since there is already one with this stamp.
  bool add(const ImuSample& sample);

  // Ignored unless wheel.enabled.
  void add(const WheelSample& sample);
  void add(const WheelsSample& sample);  // the mean of both sides counts as the wheel
  // Whether the wheel's distance was found to have jumped since the last call.
  bool take_jump() { return wheel_.take_jump(); }

  // From another process, in effect at once, whatever gpr.coherence.use says: it is not learnt from
  // the wheel. Dropped if too many wait for the first state.
  void add_external(Displacement displacement);

  // A finding of the radar front end as it is published: lengths in metres, a standstill as a
  // distance of 0. Must not be a Sight.
  Displacement in_metres(const gpr::Finding& finding);

  // A finding that is now in effect, and the result of in_metres() for it. Ignored unless valid.
  void add_radar(const gpr::Finding& finding, const PlacedDisplacement& in_metres);

  // Now in effect.
  void add_passage(const AntennaPassage& passage) {
    pair_slip_.add(passage, wheel_, newest_.state.wheel_scale);
  }

  // Whether antennas in a row have measured the path up to now, but for what they need to see.
  bool measured_by_pair() const { return pair_slip_.knows(imu_now_); }
  std::optional<double> slip_left_by_pair(TimeNs time) const { return pair_slip_.left(time); }

  // The detection limit of the radar front end.
  void add_sight(const gpr::Sight& sight);

  // m/s; the radar may miss motion slower than this. Two standard deviations above the estimate;
  // nothing while it is not known.
  std::optional<double> unseen_speed() const;
  static constexpr double kUnseenAtFirst = 0.05;  // m/s; above that of most grounds

  // The gyro shows a steady turn although all other sensors show a standstill, and a faster one
  // than a step of its bias would.
  bool turns_at_rest() const { return bias_watch_.turns_at_rest(); }

  // Do the wheels turn although the ground stands?
  Immobilised immobilised() const { return immobilised_.at(wheel_now_, wheel_); }

  // Share of the path on which the wheel slips, as learnt.
  double slip_share() const { return slip_belief_.share().value(); }
  std::optional<double> slip_left() const { return slip_belief_.left(); }
  slip::Learnt learnt_slip() const { return slip_belief_.learnt(); }
  const slip::WheelPosition& wheel_position() const { return slip_belief_.position(); }
  TimeNs judged_to() const { return judged_to_; }  // end of the newest interval judged
  // Is the wheel compared with the radar's coherence, at present?
  bool wheel_compared() const { return wheel_now_ < compared_to_ + kComparedFor; }

  // The first state and its noise, from the last initializer.duration of standstill, or of driving
  // if the robot has been on the move for some seconds; otherwise the reason why there is none.
  // Forgets the IMU's samples before that, and divides the others by the accelerometer's scale, if
  // there is a state with one. has_begun: an estimate of these data began here, and on the move
  // this one has to.
  Initialization initialize(bool has_begun = false);

  // Starts from the first state, of the initialiser or of an earlier run, with the IMU's noise at
  // standstill (after a start on the move: the sensor's own noise).
  void begin(const StateResult& first, const InitialState& initial);

  // The wheel's count at the end of an earlier run. The encoder is assumed to have counted on since
  // then.
  void resume_wheel(const WheelSample& sample) { wheel_.resume(sample); }
  void resume_pair(const LearntTurn& learnt) { pair_.resume(learnt); }
  void resume_slip(const slip::Learnt& earlier) { slip_belief_.take_up(earlier); }
  // The samples so far are divided by this; later ones come so.
  void divide_forces(double accel_scale) { imu_.divide_forces(accel_scale); }
  // While the yaw of the IMU's mounting is not known, accelerations tell nothing of slip and of the
  // wheel's scale.
  void set_axes_known(bool known) { axes_known_ = known; }
  // To other axes of the body, new from old; the newest state as well.
  void turn_axes(const Eigen::Matrix3d& R_new_old);
  // m/s^2, mean over the last initializer.duration; nothing without samples.
  std::optional<Eigen::Vector3d> mean_force() const;
  void forget_wheel() { wheel_ = WheelHistory(config_.wheel.max_speed); }

  // A newer state is in effect. Forgets samples that no later call needs.
  void adopt(const StateResult& newest);

  // What is known about the interval from the last judged state to the one at `to`. Each
  // displacement is handed out once, with the first state at or after its end.
  StateInput judge(TimeNs to);

  // Sets the flags of an estimate that is about to be published, except kNoRadar. true: the wheel
  // begins to slip.
  bool follow(OdometryEstimate& estimate);

  // What the wheel says of the way from a state on, to be used in the prediction; nullopt where it
  // says nothing: a robot that stands, or a gap of the IMU. As in the window, one that slips, is
  // late or silent does not move sideways or upwards either (but the paper's wheel is a distance
  // alone). What its samples after `heard` show of slip does not count.
  std::optional<WheelWaySince> wheel_since(TimeNs state, const PredictedWay& way,
                                           TimeNs heard) const;
  Eigen::Vector3d wheel_contact() const;

  // The IMU's noise between two times: that at standstill, or what the samples show if that is
  // more.
  ImuNoise noise(TimeNs from, TimeNs to) const;
  const ImuNoise& noise_at_standstill() const { return rest_.noise(); }

  const StateResult& newest() const { return newest_; }  // in effect
  const ImuHistory& imu() const { return imu_; }
  const WheelHistory& wheel() const { return wheel_; }
  const WheelPair& pair() const { return pair_; }
  // s, by which the wheel is late against the IMU; 0 if no delay is significant.
  double wheel_delay_s() const;

 private:
  void set_wheel_resolution(double resolution_m);
  double error_of_unknown_axes(const std::vector<MotionStep>& steps) const;
  Initialization initialize_at_rest(TimeNs from, double share);
  std::optional<ImuBias> bias_at_begin(TimeNs since) const;
  WheelAtStart wheel_at_start(TimeNs from) const;  // from there to now
  AtRest at_rest() const;
  double rolled(TimeNs from, TimeNs to) const;
  bool stands_with_engine(TimeNs now);
  void learn_rest(TimeNs to, bool with_engine);
  void learn_vibration(TimeNs from, TimeNs to);
  void compare_with_wheel();  // the paths that it has reported by now
  void follow_slip(StateInput& input);
  std::vector<PlacedDisplacement> take_displacements(TimeNs to);
  struct Waiting : PlacedDisplacement {
    bool by_coherence = false;  // learnt from the wheel
  };
  bool enters_estimate(const Waiting& waiting) const;
  void forget_old_standing();
  Displacement no_displacement(TimeNs from, TimeNs to) const;
  std::int32_t flags() const;

  static constexpr TimeNs kComparedFor = 5'000'000'000;
  // Must be longer than a state waits for the reorder window.
  static constexpr TimeNs kStandingKept = 2'000'000'000;

  // wheel.noise_floor is what the encoder's resolution makes of it; as configured in
  // wheel_floor_m_.
  Config config_;
  const double wheel_floor_m_;
  WheelTick wheel_tick_;
  const TimeNs state_period_, lag_;

  ImuHistory imu_;
  WheelHistory wheel_;
  WheelPair pair_;
  TimeNs imu_now_ = 0, wheel_now_ = 0;           // newest stamps
  std::vector<gpr::Standstill> radar_standing_;  // newest last
  std::vector<Waiting> displacements_;           // not handed out yet

  TimeNs first_imu_ = 0;
  RestLevels rest_;
  Vibration vibration_;
  int stands_in_a_row_ = 0;  // intervals, by the rules for an engine
  DriveNoise drive_noise_;
  TurnRate turn_rate_;
  WheelGap wheel_gap_;
  StateResult newest_;    // in effect
  TimeNs judged_to_ = 0;  // time of the newest judged state
  SlipWatch slip_;
  SlipBelief slip_belief_;
  PairSlip pair_slip_;
  IntervalSlip newest_slip_;                // of the last interval judged
  std::deque<gpr::PathLength> unreported_;  // end after the wheel's newest sample; oldest first
  TimeNs radar_heard_ = -kStandingKept;     // end of the radar's newest finding
  TimeNs compared_to_ = -kComparedFor;      // end of the last distance by coherence
  ImmobilisedWatch immobilised_;
  BiasWatch bias_watch_;
  CoherenceScale coherence_;
  CoherenceScale sight_;          // m/s, the detection limit of the radar
  TimeNs speed_known_after_ = 0;  // until then the speed comes from the wheel alone
  bool axes_known_ = true;
  TimeNs no_wheel_until_ = 0;  // end of the last state interval without a usable wheel
};

}  // namespace gprodom
