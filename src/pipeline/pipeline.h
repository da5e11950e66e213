// The estimator between two resets, from messages to poses. With Execution::kInline, the same
// sequence of calls gives byte-identical output.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/dated_worker.h"
#include "base/trace_format.h"
#include "estimation/state_estimator.h"
#include "gpr/pair/antenna_filter.h"
#include "gprodom/config.h"
#include "gprodom/odometry.h"
#include "gprodom/types.h"
#include "input/health.h"
#include "input/imu_mounting.h"
#include "input/input_check.h"
#include "input/mounting_search.h"
#include "input/mounting_watch.h"
#include "map/map_task.h"
#include "motion/lost_heading.h"
#include "motion/motion_judge.h"
#include "motion/slip_drift.h"
#include "persist/learnt.h"
#include "persist/saved_state.h"
#include "pipeline/factor_queue.h"
#include "pipeline/prediction.h"
#include "pipeline/radar_task.h"

namespace gprodom {

// What a pipeline takes over from the one before it, or from a saved run.
struct StartingPoint {
  std::optional<GroundMap> ground;
  std::optional<SavedState> state;         // used if it is at most state.resume_within old
  std::optional<LearntTurn> pair;          // calibration of left and right wheels
  std::optional<slip::Learnt> slip;        // of the wheel
  double accel_scale = 1.0;                // of the accelerometer
  std::optional<LearntMounting> mounting;  // of the IMU; used where the configuration says auto
  std::optional<MountingSearch> search;    // goes on
  // Data up to then have shown it, and count once. The pipeline before began at its first pose.
  TimeNs mounting_of = 0, begins_at = 0;
  bool buffers = true;  // it may be found better with the data since the start
  // The radar has another setting than the ground: saves the ground, and returns that of the new
  // setting, if there is any.
  std::function<std::optional<GroundMap>(const TraceFormat&)> ground_of;
};

class Pipeline {
 public:
  using Message = InputMessage;

  // front_end: replaces gpr.front_end unless it is empty. Throws ConfigError if settings contradict
  // each other.
  Pipeline(const Config& config, Execution execution, const gpr::FrontEndFactory& front_end,
           StartingPoint start);

  void add(Message message) { inbox_.push_back(std::move(message)); }
  void reject(const std::string& channel, const std::string& reason) {
    health_.count(channel, reason);
  }
  // Returns the reason if it is refused, otherwise an empty string.
  std::string add_factor(const UserFactor& factor);
  Outputs step();
  Outputs finish();
  // Starts the jobs submitted by step(); otherwise they start with the next step().
  void start_jobs() {
    solver_.start();
    radar_worker_.start();
    map_->start_jobs();
  }
  void record() { record_ = true; }
  const Batch& batch() const;  // throws if nothing was recorded
  // The sensors' own stamp for an internal time. They differ if the clock was set ahead.
  TimeNs sensor_stamp(TimeNs time) const { return input_.sensor_stamp(time); }
  std::vector<NavState> smoothed(std::map<int, FixAntenna>* antennas) const;
  Timing timing() { return {solver_.work_time(), radar_worker_.work_time()}; }

  // The current state, for the next pipeline or run. Nothing before the start, or if the last solve
  // failed. correction: the one in effect.
  std::optional<SavedState> state(const std::optional<Correction>& correction) const;
  // What a pipeline after this one knows from the begin, but for ground and state.
  StartingPoint learnt() const;
  // The correction of the resumed state; returned once.
  std::optional<Correction> take_resumed_correction() {
    return std::exchange(resumed_correction_, std::nullopt);
  }
  TimeNs now() const { return imu_now_; }  // data time
  MapTask& map() { return *map_; }
  void drain();
  // The radar's setting, once it is known.
  std::optional<TraceFormat> trace_format() const { return input_.trace_format(); }
  // Replaces the map by one that has this ground of an earlier run, and begins a new track in it.
  void set_ground(GroundMap ground);
  void locate_at(const ToldPlace& place) {
    if (map_waits_) told_ = place;
    map_->locate_at(place);
  }
  // Keeps these in the status until they are empty: what cannot be written, which map file has
  // another name now, and that the radar has another setting than ground.map.
  void report_files(const std::string& trouble, const std::string& kept_aside,
                    const std::string& other_format) {
    health_.set("state files", HealthLevel::kDegraded, trouble);
    health_.await("map files", HealthLevel::kOk, kept_aside);
    health_.set("map format", HealthLevel::kDegraded, other_format);
  }

  // The clock was set, so the state refers to another time. The next pipeline takes the inbox.
  bool must_restart() const { return input_.clock_moved(); }
  std::deque<Message> take_inbox() { return std::exchange(inbox_, {}); }

  // Whether it keeps the data since the start, with which the mounting of the IMU may still be
  // found.
  bool buffers() const { return buffers_; }
  bool map_waits() const { return map_waits_; }
  const std::deque<Message>& buffer() const { return buffer_; }
  // It has been found, or found better, since the last call.
  bool take_found() { return std::exchange(found_, false); }
  // For a pipeline that estimates these data again. Takes the ground.
  StartingPoint rerun_start();
  // Whether the mounting will be found better while the data are kept.
  bool may_buffer() const;
  void stop_buffering();
  const std::optional<ToldPlace>& told() const { return told_; }

 private:
  // Stations of a message, in the order step() visits them.
  void store(Message& message);
  void store_trace(GprTrace trace);
  void add_to_map(const GprTrace& trace);
  void count_jump();
  void start();
  bool resume();
  void begin(const InitialState& initial, const StateResult& first);
  void find_mounting(const StartingPoint& start);
  void level_imu();
  std::optional<Eigen::Matrix3d> take_mounting();
  void search_since(TimeNs from, const NavState& first);
  void search_mounting(TimeNs to, const std::vector<MotionStep>& steps,
                       const Eigen::Vector3d& gyro_bias);
  void watch_mounting(const StateInput& input);
  std::string mounting_text() const;
  LearntMounting learnt_mounting() const {
    return {Eigen::Quaterniond(imu_mounting_.R_body_imu()), search_.yaw_sigma()};
  }
  void buffer_message(const Message& message);
  void prune_buffer();
  void take_radar_answers();
  void take_passage(const gpr::Passage& passage, TimeNs effective);
  std::optional<Eigen::Vector3d> place_of(int antenna) const;
  void report_antennas(gpr::PairState state);
  void keep_way(const StateResult& result);
  gpr::Travel travel() const;
  void take_states();
  void take_map_answers();
  void ask_radar();
  void make_states();
  void publish();
  void report_accelerometer();
  void report_pair();
  void report_place(const MapAnswer& answer);
  void report_fixes(const FixReport& fixes);
  void report_trigger();
  void report_sight();
  void report_slip();
  void publish_pose(OdometryEstimate estimate);
  // An output with the sensors' own stamp.
  template <typename T>
  T stamped(T output) const {
    output.time = sensor_stamp(output.time);
    return output;
  }
  Displacement stamped(Displacement displacement) const;

  void adopt(StateResult result, TimeNs effective);

  const Config config_;
  const Execution execution_;
  const TimeNs reorder_window_, state_period_, tick_period_;
  ImuMounting imu_mounting_;
  std::deque<Message> inbox_;
  Outputs out_;
  Health health_;

  InputCheck input_;
  TimeNs imu_now_ = 0;  // newest IMU stamp: the estimator's clock

  MotionJudge motion_;
  std::vector<GprTrace> traces_;    // since the last tick
  std::vector<GprTrace> unagreed_;  // for the map, until the radar's setting is known
  std::optional<TraceFormat> ground_format_;
  const std::function<std::optional<GroundMap>(const TraceFormat&)> ground_of_;
  FactorQueue factors_;
  MountingWatch mounting_;
  const bool finds_mounting_;  // imu.rpy_body_imu is auto
  MountingSearch search_;
  TimeNs searched_to_;
  // While the mounting may still be found with them: the data since the start.
  bool buffers_ = false, found_ = false;
  bool map_waits_ = false;  // since the axes are not known
  std::deque<Message> buffer_;
  std::size_t buffer_bytes_ = 0;
  TimeNs moves_since_ = 0;
  std::optional<ToldPlace> told_;
  std::optional<LearntTurn> earlier_pair_;  // of earlier runs
  std::optional<slip::Learnt> earlier_slip_;

  std::optional<Correction> resumed_correction_;
  std::optional<SavedState> saved_;  // to resume from; empty after the first attempt
  bool started_ = false, record_ = false;
  TimeNs begins_at_, began_at_ = 0;  // not before; did
  TimeNs next_start_try_ = 0, next_tick_ = 0, next_status_ = 0;
  TimeNs next_state_ = 0;
  Prediction prediction_;
  SlipDrift slip_drift_;
  LostHeading lost_heading_;
  gpr::AntennaFilter antenna_filter_;
  gpr::Travel travel_;  // along which antennas in a row are matched; empty without them

  // Each is used by the jobs of one worker only. Declared before the workers, so that it outlives
  // their jobs.
  std::unique_ptr<StateEstimator> estimator_;
  RadarTask radar_;
  DatedWorker<StateResult> solver_;
  DatedWorker<RadarAnswer> radar_worker_;
  int map_number_ = 0;
  bool has_earlier_ground_, located_ = false;
  bool sight_warned_ = false;
  std::unique_ptr<MapTask> map_;
};

}  // namespace gprodom
