// From messages to poses: the estimator between two resets. Same sequence of calls, same output, to
// the byte (with Execution::kInline).
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/odometry.h"
#include "gprodom/state_estimator.h"
#include "gprodom/types.h"
#include "pipeline/coherence_scale.h"
#include "pipeline/dated_worker.h"
#include "pipeline/health.h"
#include "pipeline/map_task.h"
#include "pipeline/prediction.h"
#include "pipeline/radar_task.h"
#include "pipeline/sensor_history.h"
#include "pipeline/slip_watch.h"
#include "pipeline/time_guard.h"

namespace gprodom {

class Pipeline {
 public:
  using Message = std::variant<ImuSample, WheelSample, GprTrace, Displacement>;

  // Throws ConfigError where settings contradict each other.
  Pipeline(const Config& config, Execution execution);

  void add(Message message) { inbox_.push_back(std::move(message)); }
  void reject(const std::string& channel, const std::string& reason) {
    health_.count(channel, reason, now_);
  }
  Outputs step();
  Outputs finish();
  void record() { record_ = true; }
  const Batch& batch() const;  // throws where nothing was recorded
  std::vector<NavState> smoothed() const;
  Timing timing() { return {solver_.work_time(), radar_worker_.work_time(), map_.work_time()}; }

  // The clock was set: what is known refers to another time. The inbox goes on in a new Impl.
  bool must_restart() const { return imu_guard_.moved(); }
  std::deque<Message> take_inbox() { return std::exchange(inbox_, {}); }

 private:
  // Stations of a message, in the order step() visits them.
  bool accept(Message& message);
  void store(Message& message);
  void start_if_standing();
  void take_radar_answers();
  void take_states();
  void take_map_answers();
  void ask_radar();
  void make_states();
  void publish();

  StateInput collect(TimeNs from, TimeNs to);
  bool wanted(const Displacement& d) const;
  void use(const StateResult& result, TimeNs effective);
  std::int32_t flags() const;
  void watch_sensors();

  const Config config_;
  const TimeNs reorder_window_, state_period_, tick_period_;
  const Eigen::Matrix3d R_body_imu_;
  std::deque<Message> inbox_;
  Outputs out_;
  Health health_;

  TimeGuard imu_guard_, wheel_guard_, gpr_guard_, displacement_guard_;
  TimeNs now_ = 0;      // newest stamp accepted from any sensor
  TimeNs imu_now_ = 0;  // newest IMU stamp: the estimator's clock
  TimeNs wheel_now_ = 0, gpr_now_ = 0;

  ImuHistory imu_;
  WheelHistory wheel_;
  std::vector<GprTrace> traces_;                 // since the last tick
  std::vector<Displacement> radar_standing_;     // in effect, newest last
  std::vector<Displacement> new_displacements_;  // in effect, for the next state

  bool started_ = false, record_ = false;
  TimeNs next_start_try_ = 0, next_tick_ = 0, next_status_ = 0;
  TimeNs newest_state_ = 0, next_state_ = 0;
  ImuNoise reference_noise_;  // at standstill
  Prediction prediction_;
  SlipWatch slip_;
  CoherenceScale coherence_;
  TimeNs wheel_doubted_ = 0;  // end of the last state interval without a wheel that can be used

  // Used by the jobs of one worker alone; declared before the workers, which no job outlives.
  std::unique_ptr<StateEstimator> estimator_;
  RadarTask radar_;
  DatedWorker<StateResult> solver_;
  DatedWorker<RadarAnswer> radar_worker_;
  MapTask map_;
};

}  // namespace gprodom
