// Immobilised: the wheels turn and the ground under the antenna stands (the term is that of Ward
// and Iagnemma 2007, who detect it with the IMU).
//
// The radar detects the standstill. But over ground without texture the traces stay the same while
// the robot creeps, so the radar alone is not enough:
//  - The wheel must have turned by 0.1 to 0.15 m since the standstill began, and the trace must be
//    the same as at the beginning (gpr::Standstill::since).
//  - The share of the recent path on which the radar would not have seen that travel is the
//    probability of such a standstill while the robot rolls. A flag that proved wrong adds to it.
//  - The IMU's change of speed at the beginning gives the odds of standing against rolling. Share
//    and odds together decide.
// docs/observability.md, "Immobilised".
#pragma once

#include <deque>

#include "estimation/state_input.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/history/sensor_history.h"

namespace gprodom {

enum class Immobilised {
  kNo,
  kCannotTell,  // the ground has no texture here: standstill and slow motion look the same
  kYes
};

class ImmobilisedWatch {
 public:
  // ns; for which the IMU's history is needed.
  static constexpr TimeNs kMemory = 10'000'000'000;

  // A state in effect, with its covariance. Call for each in time order.
  void add(const StateResult& state);

  // How well the radar saw motion over some time, in which the wheel turned by `wheel_m` (signed).
  void add(const gpr::Sight& sight, double wheel_m);

  // The radar says that the antenna stands. `scale`: wheel, reported over true distance.
  // `accel_density`: of driving, m/s^2/sqrt(Hz).
  void add(const gpr::Standstill& standstill, const WheelHistory& wheel, const ImuHistory& imu,
           double scale, double accel_density);

  // What holds at `now`. kYes ends when the wheel stops, or the radar no longer says standstill.
  Immobilised at(TimeNs now, const WheelHistory& wheel) const;

 private:
  // A past state, with the variances of its speed along the track, (m/s)^2, and of the error of an
  // acceleration along the track by tilt and bias, (m/s^2)^2.
  struct Known {
    NavState state;
    double speed_variance, accel_error_variance;
    bool standing;
  };
  struct Seen {
    TimeNs from, to;
    double way_m, least_m;  // travel of the wheel; least travel that the radar would have seen
  };

  void forget_after(TimeNs time);
  double blind_share(TimeNs before, double travel_m) const;
  const Known* reference(TimeNs since, TimeNs wheel_turns) const;
  double log_odds_by_imu(const Known& from, TimeNs to, double wheel_mps, const ImuHistory& imu,
                         double accel_density) const;

  std::deque<Known> states_;
  std::deque<Seen> seen_;  // of the last kRecent_m of the path, oldest first
  double seen_m_ = 0.0;
  Immobilised now_ = Immobilised::kNo;
  TimeNs detected_since_ = 0, detected_to_ = 0;  // of the standstill that now_ refers to
};

}  // namespace gprodom
