// What goes into the estimator with each state, and what comes out.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/pair_way.h"
#include "estimation/increments/recent_motion.h"
#include "estimation/marginal_prior.h"
#include "estimation/nav_state.h"
#include "estimation/rolled_way.h"
#include "estimation/window_solver.h"
#include "gprodom/types.h"
#include "gprodom/user_factor.h"

namespace gprodom {

// Noise in a gap of the IMU of at most kLongestBridge, over which values are interpolated:
// densities that cover a robot's changes of rate and speed in that time (docs/estimation.md, "Gaps
// of the IMU").
constexpr ImuNoise kBridgedImuNoise{0.03, 0.5};

// The longest gap of the IMU that a solve bridges. Beyond, the wheel alone predicts the state.
constexpr double kLongestBridge = 0.3;  // s

// The prior of the origin, which is where the robot starts: small, but not so small that the solver
// loses digits.
constexpr double kOriginPositionSigma = 1e-3;  // m
constexpr double kOriginYawSigma = 1e-3;       // rad

// Replaces the velocity of a state that was found to be wrong, by wheel or radar.
struct SpeedCorrection {
  double speed = 0.0, sigma = 0.0;  // m/s, forwards
  double ahead_m = 0.0;             // signed; the robot is this far ahead of the state's position
};

// Estimate of the wheel's slip in the interval that ends with a state.
struct IntervalSlip {
  TimeNs to = 0;
  double l = 0.0, sigma = 0.0;  // ln(true distance / distance by the wheel)
};

// Of a point of the body: gpr.lever_arm, or that of another antenna.
struct PlacedDisplacement : Displacement {
  PlacedDisplacement() = default;
  explicit PlacedDisplacement(Displacement displacement,
                              std::optional<Eigen::Vector3d> at = std::nullopt)
      : Displacement(std::move(displacement)), lever_arm(std::move(at)) {}
  std::optional<Eigen::Vector3d> lever_arm;  // m, in body
};

// What is known about the interval from the newest state to a new one.
struct StateInput {
  TimeNs time = 0;  // of the new state
  std::vector<MotionStep> steps;
  ImuNoise noise;  // of the IMU over the interval
  bool has_wheel = false;
  double wheel_sigma_m = 0.0;       // of the wheel's distance, learnt; used if above wheel.noise
  double wheel_floor_m = 0.0;       // error of any distance by the encoder's resolution
  double speed_change = 0.0;        // m/s in a second, as it usually changes; 0: not known
  double turn_variance = 0.0;       // rad^2, of the sum of the steps' gap_turn
  bool wheel_late = false;          // delayed: accelerations cannot show the wheel's scale
  double wheel_delay_s = 0.0;       // learnt; 0 if none is significant
  double wheel_y_m = 0.0;           // lateral position of the wheel's contact point in body
  bool standing = false;            // a standstill was detected
  bool wheel_contradicted = false;  // the robot does not move as the wheel says
  // rad/s, body; set if a standstill shows that the bias has changed by more than its walk.
  std::optional<Eigen::Vector3d> gyro_bias;
  // The body has other axes from the newest state on, new from old, as have the steps.
  std::optional<Eigen::Matrix3d> turned_axes;
  bool axes_known = true;  // else accelerations tell nothing of the wheel's scale
  std::optional<SpeedCorrection> speed_correction;  // for the interval's beginning
  std::optional<CountedWay> counted;                // of a gap of the wheel that has ended
  std::vector<IntervalSlip> slips;                  // of this interval and of earlier ones
  std::vector<PlacedDisplacement> displacements;    // newly in effect, for any earlier time
  std::vector<AntennaPassage> passages;             // likewise
  std::vector<UserFactor> factors;                  // likewise
  // States from then on stay in the window beyond the lag: passages to come, or a count, begin
  // there.
  std::optional<TimeNs> keep_since;
};

// s after which the pose graph takes a state as it is. After a longer wait more slip has shown, but
// the map is late, which costs more; 0.4 to 2 s differ by 3 % of the error. Where passages or a
// count are still to come, it waits for them.
constexpr double kSettledAfter = 1.0, kSettledWhereMeasured = 4.0;

struct StateResult {
  NavState state;  // the newest
  StateMatrix covariance = StateMatrix::Zero();
  std::optional<NavState> settled;         // newest settled state, as the window has it now
  std::optional<NavState> before_settled;  // the one before it, likewise, while it is in there
  double settled_slip_sigma = 0.0;         // of the wheel's slip in the interval before that state
  // Likewise, as antennas in a row leave it, if there are any: 0 where they measured the distance.
  std::optional<double> settled_slip_by_pair;
  SolveSummary solve;
  bool standing = false;
  bool no_wheel = false;
  bool bridged = false;  // IMU data were missing
  bool carried = false;  // for so long that the wheel alone predicts the state
  int displacements_used = 0, displacements_dropped = 0;
  // Slip that was not detected (motion/slip_drift.h): standard deviation of l over the last
  // interval (as it is, and if no antennas had measured the distance).
  double slip_sigma = 0.0, unmeasured_slip_sigma = 0.0;
  // Of the position (x, y, m^2), by that slip and by a heading that is lost
  // (motion/lost_heading.h); not part of `covariance`.
  Eigen::Matrix2d unmodelled_covariance = Eigen::Matrix2d::Zero();
  std::vector<WayPoint> way;  // of the window's states, if antennas in a row are matched along it
  int factors_used = 0;
  // Information of these factors on the position (x, y), 1/m^2.
  Eigen::Matrix2d place_information = Eigen::Matrix2d::Zero();
  struct Refused {
    std::string factor, reason;
  };
  std::vector<Refused> refused;
};

// m/s^2. An accelerometer whose gravity is off by more is not calibrated.
inline constexpr double kOutOfCalibration = 3 * kAccelBiasSigma;

// The first state with its prior, from the initialiser.
struct InitialState {
  NavState state;
  MarginalPrior prior;
  ImuNoise noise;
  bool on_the_move = false;  // no standstill yet: the IMU's noise at rest is not known
  // Of the accelerometer, by gravity: the state is that of samples whose forces are divided by it.
  double accel_scale = 1.0;
};

}  // namespace gprodom
