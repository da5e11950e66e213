// The published pose: the newest state in effect, propagated by the IMU to its newest sample, and
// by the wheel as far as it has been heard.
#pragma once

#include <deque>

#include "estimation/predict.h"
#include "estimation/state_input.h"
#include "gprodom/types.h"
#include "motion/history/sensor_history.h"

namespace gprodom {

class Prediction {
 public:
  // Starts from a new state and integrates the IMU samples since then again. contact_body: m, of
  // the wheel.
  void rebase(const StateResult& base, const ImuNoise& noise, const Eigen::Vector3d& contact_body,
              const ImuHistory& imu);

  // Propagates to `now` and returns the estimate there. Its time never decreases.
  OdometryEstimate advance(const ImuHistory& imu, TimeNs now);

  // The way that the IMU predicts from the state to a time, at most `to`; nullptr if there is none
  // yet.
  const PredictedWay* way(TimeNs to) const;
  // Corrects the estimate that advance() has just returned.
  void take_wheel(const PredictedWay& way, const WheelWaySince& wheel, double robust_threshold,
                  OdometryEstimate& estimate) const {
    gprodom::take_wheel(base_.state, base_.covariance, since_, kStandardGravity, way, wheel,
                        robust_threshold, estimate);
  }

  // Continues to count the distance from this value.
  void resume(double distance_m) { distance_m_ = distance_m; }
  double distance_m() const { return distance_m_; }

  const StateResult& base() const { return base_; }
  // Whether an estimate now would span a gap of the IMU that is too long to be bridged by holding
  // its values.
  bool lost() const { return bridged_s_ > kLongestBridge || (base_.carried && bridged_s_ > 0.0); }
  TimeNs time() const { return time_; }
  NavState state() const { return propagate(base_.state, since_, kStandardGravity); }
  Eigen::Vector3d position() const { return state().p_odom; }

 private:
  void integrate(const ImuHistory& imu, TimeNs from, TimeNs to);

  StateResult base_;
  ImuNoise noise_;
  ImuPreintegration since_;  // from base_ to time_
  Eigen::Vector3d contact_body_ = Eigen::Vector3d::Zero();
  std::deque<PredictedWay> ways_;  // one for each step of since_
  double bridged_s_ = 0.0;         // duration of the gaps in it
  TimeNs time_ = 0;
  Eigen::Vector3d omega_body_ = Eigen::Vector3d::Zero();
  double distance_m_ = 0.0;  // published so far
  // Position up to which the distance is counted: of the newest estimate that spans no long gap.
  Eigen::Vector3d p_counted_odom_ = Eigen::Vector3d::Zero();
};

// The first state in the form of a solve's result.
StateResult initial_result(const InitialState& initial);

}  // namespace gprodom
