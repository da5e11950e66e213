// From messages to poses: the estimator between two resets. Same sequence of calls, same output, to
// the byte (with Execution::kInline).
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/dated_worker.h"
#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/odometry.h"
#include "gprodom/types.h"
#include "input/health.h"
#include "input/input_check.h"
#include "input/mounting_watch.h"
#include "map/map_task.h"
#include "motion/motion_judge.h"
#include "motion/slip_drift.h"
#include "persist/saved_state.h"
#include "pipeline/factor_queue.h"
#include "pipeline/prediction.h"
#include "pipeline/radar_task.h"

namespace gprodom {

// What a pipeline starts with: the ground and the state of the one before, or of a saved run.
struct StartingPoint {
  std::optional<GroundMap> ground;
  std::optional<SavedState> state;  // gone on from where it is state.resume_within old at most
  std::optional<LearntTurn> pair;   // of left and right wheels
};

class Pipeline {
 public:
  using Message = InputMessage;

  // front_end: in place of gpr.front_end; empty: that one. Throws ConfigError where settings
  // contradict each other.
  Pipeline(const Config& config, Execution execution, const gpr::FrontEndFactory& front_end,
           StartingPoint start);

  void add(Message message) { inbox_.push_back(std::move(message)); }
  void reject(const std::string& channel, const std::string& reason) {
    health_.count(channel, reason);
  }
  // Returns why it is refused; empty: it is not.
  std::string add_factor(const UserFactor& factor);
  Outputs step();
  Outputs finish();
  // The workers take up what step() has given them; else they do with the next one.
  void start_jobs() {
    solver_.start();
    radar_worker_.start();
    map_->start_jobs();
  }
  void record() { record_ = true; }
  const Batch& batch() const;  // throws where nothing was recorded
  // The sensors' own stamp of a time of the batch: another where their clock was set ahead.
  TimeNs told(TimeNs time) const { return input_.told(time); }
  std::vector<NavState> smoothed() const;
  Timing timing() { return {solver_.work_time(), radar_worker_.work_time()}; }

  // For the next pipeline, or run. What is known now; nothing before the start, or while no solve
  // is usable. correction: in force.
  std::optional<SavedState> state(const std::optional<Correction>& correction) const;
  // Likewise of left and right wheels; nothing where they are not heard, or turn nothing.
  std::optional<LearntTurn> learnt_pair() const { return motion_.pair().learnt(); }
  // Of the state gone on from, once after that.
  std::optional<Correction> take_resumed_correction() {
    return std::exchange(resumed_correction_, std::nullopt);
  }
  // Whether there is one; only then save_ground().
  bool has_map() const { return map_->enabled(); }
  // Waits for the map's work, and leaves the map without ground.
  GroundMap take_ground() { return map_->take_ground(); }
  // As a file's. Waits for the map's work.
  std::string ground_bytes() { return map_->ground_bytes(); }
  void drain();
  // Goes on with that ground as the one from before, once the map's work is done; the track begins
  // anew in the map.
  void use_ground(GroundMap ground);
  void locate_at(const ToldPlace& place) { map_->locate_at(place); }
  // Once the map's jobs so far are done, on their thread.
  void save_ground(std::function<void(std::string)> take) {
    map_->save_ground(imu_now_, std::move(take));
  }
  // Told in the status for as long as it holds; empty: it does not.
  void tell_of_files(const std::string& trouble) {
    health_.set("state files", HealthLevel::kDegraded, trouble);
  }

  // The clock was set: what is known refers to another time. The inbox goes on in a new Impl.
  bool must_restart() const { return input_.clock_moved(); }
  std::deque<Message> take_inbox() { return std::exchange(inbox_, {}); }

 private:
  // Stations of a message, in the order step() visits them.
  void store(Message& message);
  void count_jump(bool usable);
  void start();
  bool resume();
  void begin(const InitialState& initial, const StateResult& first);
  void take_radar_answers();
  void take_states();
  void take_map_answers();
  void ask_radar();
  void make_states();
  void publish();
  void tell_of_pair();
  void tell_of_place(const MapAnswer& answer);
  void tell_of_sight();
  void tell_of_slip();
  void publish_pose(OdometryEstimate estimate);
  // What goes out, with the sensors' own stamps.
  template <typename T>
  T stamped(T output) const {
    output.time = told(output.time);
    return output;
  }
  Displacement stamped(Displacement displacement) const;

  void adopt(StateResult result, TimeNs effective);

  const Config config_;
  const Execution execution_;
  const TimeNs reorder_window_, state_period_, tick_period_;
  const Eigen::Matrix3d R_body_imu_;
  std::deque<Message> inbox_;
  Outputs out_;
  Health health_;

  InputCheck input_;
  TimeNs imu_now_ = 0;  // newest IMU stamp: the estimator's clock

  MotionJudge motion_;
  std::vector<GprTrace> traces_;  // since the last tick
  FactorQueue factors_;
  MountingWatch mounting_;

  std::optional<Correction> resumed_correction_;
  std::optional<SavedState> saved_;  // to go on from, until the first start
  bool started_ = false, record_ = false;
  TimeNs next_start_try_ = 0, next_tick_ = 0, next_status_ = 0;
  TimeNs next_state_ = 0;
  Prediction prediction_;
  SlipDrift slip_drift_;

  // Used by the jobs of one worker alone; declared before the workers, which no job outlives.
  std::unique_ptr<StateEstimator> estimator_;
  RadarTask radar_;
  DatedWorker<StateResult> solver_;
  DatedWorker<RadarAnswer> radar_worker_;
  int map_number_ = 0;
  bool ground_from_before_, located_ = false;
  bool told_of_sight_ = false;
  std::unique_ptr<MapTask> map_;
};

}  // namespace gprodom
