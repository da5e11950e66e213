// From the sensors' data of one state interval to factors, a solve and a snapshot of the result.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimation/batch.h"
#include "estimation/drive_traits.h"
#include "estimation/fixed_lag_smoother.h"
#include "estimation/recent_motion.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "gprodom/user_factor.h"

namespace gprodom {

// Of IMU data that are missing for kLongestBridge at most, with the values held: densities that
// cover what a robot turns and speeds up meanwhile (docs/estimation.md, "Gaps of the IMU").
constexpr ImuNoise kBridgedImuNoise{0.03, 0.5};

// A gap of the IMU that a solve bridges. Beyond, the state is carried on by the wheel alone.
constexpr double kLongestBridge = 0.3;  // s

struct CarriedState;

// A state's velocity is found wrong: the speed that the wheel or the radar gives instead.
struct SpeedCorrection {
  double speed = 0.0, sigma = 0.0;  // m/s, forwards
  double ahead_m = 0.0;             // by which the robot is ahead of the state's place, signed
};

// What the wheel's distance is worth in the interval that ends with a state.
struct IntervalSlip {
  TimeNs to = 0;
  double l = 0.0, sigma = 0.0;  // ln(true distance / distance by the wheel)
};

// What is known about the interval from the newest state to a new one.
struct StateInput {
  TimeNs time = 0;  // of the new state
  std::vector<MotionStep> steps;
  ImuNoise noise;  // of the IMU over the interval
  bool has_wheel = false;
  double wheel_sigma_m = 0.0;       // of the wheel, as learnt: where it is above wheel.noise
  double turn_variance = 0.0;       // rad^2, of the steps' wheel_turn together
  bool wheel_late = false;          // so that accelerations tell nothing of the wheel's scale
  bool standing = false;            // proven: the robot did not move
  bool wheel_contradicted = false;  // the robot stands, or moves otherwise than the wheel says
  // rad/s, body; where a standstill shows that the bias has moved by more than its walk.
  std::optional<Eigen::Vector3d> gyro_bias;
  std::optional<SpeedCorrection> speed_correction;  // for the interval's beginning
  std::vector<IntervalSlip> slips;                  // of this interval and of those before it
  std::vector<Displacement> displacements;          // newly in effect, of any earlier time
  std::vector<UserFactor> factors;                  // likewise
};

struct StateResult {
  NavState state;  // the newest
  StateMatrix covariance = StateMatrix::Zero();
  std::optional<NavState> settled;  // the state graph.settle before it, as the window now has it
  double settled_slip_sigma = 0.0;  // of what is believed of the wheel's slip just before that
  SolveSummary solve;
  bool standing = false;
  bool no_wheel = false;
  bool bridged = false;  // IMU data were missing
  bool carried = false;  // for so long that the state rests on the wheel alone
  int displacements_used = 0, displacements_dropped = 0;
  // Of slip that nothing has seen (motion/slip_drift.h), not part of `covariance`: the standard
  // deviation of l over the last interval, and what it makes of the position, x and y, m^2.
  double slip_sigma = 0.0;
  Eigen::Matrix2d slip_covariance = Eigen::Matrix2d::Zero();
  int factors_used = 0;
  // What they measured of the place beside the window's own knowledge, x and y, 1/m^2.
  Eigen::Matrix2d place_information = Eigen::Matrix2d::Zero();
  struct Refused {
    std::string factor, reason;
  };
  std::vector<Refused> refused;
};

// The first state with its prior, from the initialiser.
struct InitialState {
  NavState state;
  MarginalPrior prior;
  ImuNoise noise;
  bool on_the_move = false;  // no standstill: what the IMU is like at rest is not known
};

// A prior that knows a state with a covariance, which must be positive definite.
MarginalPrior gaussian_prior(const NavState& state, const StateMatrix& covariance);

// Owns the smoother. One thread at a time.
class StateEstimator {
 public:
  StateEstimator(const Config& config, const InitialState& initial);

  // A failed solve leaves the states as predicted from the last good ones and says so in the
  // result. Never throws on data.
  StateResult add(const StateInput& input);

  const FixedLagSmoother& smoother() const { return smoother_; }

  // Keeps every state and factor from here on, for a solution over the whole run. Call it before
  // the first add().
  void record();
  const Batch* recorded() const { return batch_ ? &*batch_ : nullptr; }

 private:
  void add_wheel_factor(const StateInput& input, FixedLagSmoother::StateId a,
                        FixedLagSmoother::StateId b);
  void learn_slips(const std::vector<IntervalSlip>& slips);
  std::shared_ptr<const WheelSlipTerm> slip_of(TimeNs time) const;  // null: not known
  bool add_displacement(const Displacement& displacement);
  // Returns why not; empty: it is in. Adds to the information on the place.
  std::string add_user_factor(const UserFactor& factor, Eigen::Matrix2d& place_information);
  void solve(FixedLagSmoother::StateId newest, const NavState& predicted, StateResult& result);
  void give_up(const NavState& state);
  void carry_over(const StateInput& input);
  void go_on_from(const CarriedState& state);
  void restart(const NavState& state);
  void hold_scale();
  StateMatrix covariance_of_held_scale() const;
  bool tie(FixedLagSmoother::StateId a, FixedLagSmoother::StateId b,
           std::shared_ptr<const Factor> factor);

  Config config_;
  DriveTraits drive_;
  Eigen::Vector3d gravity_odom_;
  // The wheel's scale stays as it was at the start, as uncertain as it was. Below no covariance
  // knows of that.
  bool scale_held_;
  double first_scale_, first_scale_sigma_;
  Eigen::Vector3d start_;        // in odom
  StateMatrix last_covariance_;  // of the last state that a solve ended with, common_ included
  NavState bias_known_;          // the last state whose gyro bias a standstill bore out
  StateMatrix common_ = StateMatrix::Zero();  // of place and heading since the last restart
  double gap_s_ = 0.0;                        // since the IMU fell silent, up to the newest state
  FixedLagSmoother smoother_;
  std::deque<std::pair<TimeNs, std::shared_ptr<WheelSlipTerm>>> slips_;  // of the window's wheel
  RecentMotion motion_;                      // since the states of the window
  FixedLagSmoother::StateId id_offset_ = 0;  // of the smoother's states since its last restart
  std::optional<Batch> batch_;
};

}  // namespace gprodom
