// Turns the sensor data of one state interval into factors, solves, and returns the result.
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
#include "estimation/increments/recent_motion.h"
#include "estimation/state_input.h"
#include "estimation/unobserved_errors.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "gprodom/user_factor.h"

namespace gprodom {

// Owns the smoother. One thread at a time.
class StateEstimator {
 public:
  StateEstimator(const Config& config, const InitialState& initial);

  // If the solve fails, the states stay as predicted from the last good ones, and the result says
  // so. Never throws on data.
  StateResult add(const StateInput& input);

  const FixedLagSmoother& smoother() const { return smoother_; }

  // Keeps every state and factor for a batch solution over the whole run. Call it before the first
  // add().
  void record();
  const Batch* recorded() const { return batch_ ? &*batch_ : nullptr; }

 private:
  void take_corrections(const StateInput& input);
  void add_motion(const StateInput& input, const ImuPreintegration& imu,
                  FixedLagSmoother::StateId b);
  void add_measurements(const StateInput& input, StateResult& result);
  void add_wheel_factor(const StateInput& input, FixedLagSmoother::StateId a,
                        FixedLagSmoother::StateId b);
  void update_slips(const std::vector<IntervalSlip>& slips);
  void update_places(const StateInput& input);
  std::shared_ptr<const WheelSlipTerm> slip_of(TimeNs time) const;  // null: not known
  bool add_displacement(const PlacedDisplacement& displacement);
  bool add_passage(const AntennaPassage& passage);
  // A measurement between two times, tied to the states nearest to them.
  struct Span {
    FixedLagSmoother::StateId a, b;
    double offset_a_s, offset_b_s;
  };
  std::optional<Span> span(TimeNs from, TimeNs to) const;
  std::vector<WayPoint> way() const;
  // Returns the reason if the factor is refused, otherwise an empty string. Adds the factor's
  // information to place_information.
  std::string add_user_factor(const UserFactor& factor, Eigen::Matrix2d& place_information);
  void settle(std::optional<TimeNs> keep_since, StateResult& result);
  void solve(const StateInput& input, FixedLagSmoother::StateId newest, const NavState& predicted,
             StateResult& result);
  void discard_window(const NavState& state);
  void carry_over(const StateInput& input);
  void take_count(const StateInput& input);
  void continue_from(const CarriedState& state);
  void restart(const NavState& state);
  CarriedState now() const;
  // `in_batch`: the factor's place in the solution over all data, if that is another one.
  bool add_factor(FixedLagSmoother::StateId a, FixedLagSmoother::StateId b,
                  const std::shared_ptr<const Factor>& factor,
                  const std::shared_ptr<const Factor>& in_batch = nullptr);

  Config config_;
  DriveTraits drive_;
  Eigen::Vector3d gravity_odom_;
  // The covariances below are without what these say.
  HeldScale scale_;
  LastingErrors lasting_errors_;
  StateMatrix last_covariance_;  // of the newest state at the last solve, common_ included
  NavState bias_confirmed_;      // the last state whose gyro bias a standstill has confirmed
  // Error of position and heading at the last restart, common to all states since then.
  StateMatrix common_ = StateMatrix::Zero();
  double gap_s_ = 0.0;  // length of the current gap of the IMU, up to the newest state
  FixedLagSmoother smoother_;
  std::optional<FixedLagSmoother::StateId> settled_;                     // the newest that is
  std::deque<std::pair<TimeNs, std::shared_ptr<WheelSlipTerm>>> slips_;  // of the window's factors
  std::deque<std::pair<TimeNs, std::shared_ptr<WheelPlaceTerm>>> places_;  // likewise
  RecentMotion motion_;                                                    // over the window
  FixedLagSmoother::StateId id_offset_ = 0;  // number in the batch of the smoother's first state
  std::optional<Batch> batch_;
};

}  // namespace gprodom
