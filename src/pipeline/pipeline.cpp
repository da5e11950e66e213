#include "pipeline/pipeline.h"

#include <algorithm>
#include <iterator>

#include "gprodom/error.h"
#include "input/plausibility.h"

namespace gprodom {

namespace {

// A solver that is too slow gets fewer states: as soon as those of kMostBehind (s) wait, the next
// one ends a longer interval, up to kLongestInterval (s), as a low smoother.state_rate has it. If
// even so many wait as make a minute, IMU samples are dropped as if the IMU had stopped.
constexpr double kMostBehind = 1.0, kLongestInterval = 1.0;
constexpr std::size_t kMostSolves = 60;

// Messages of different sensors may overtake each other on their way by so much (ns). The published
// pose takes no newer wheel sample, so that it does not depend on which came first.
constexpr TimeNs kOvertakes = 50'000'000;

// The first multiple of the period after a time: the grid of radar ticks and of states.
TimeNs next_multiple(TimeNs time, TimeNs period) { return (time / period + 1) * period; }

void check_consistency(const Config& config) {
  const SmootherConfig& c = config.smoother;
  if (c.latency >= 1 / c.state_rate)
    throw ConfigError("smoother.latency: expected less than one state interval, 1 / state_rate");
  if (c.lag < 2 / c.state_rate)
    throw ConfigError("smoother.lag: expected at least two state intervals, 2 / state_rate");
  if (config.gpr.trigger != Trigger::kTime && config.gpr.coherence.use == CoherenceUse::kAlways)
    throw ConfigError(
        "gpr.coherence.use: expected contradicted or never: traces that come by distance "
        "(gpr.trigger) tell no speed");
}

}  // namespace

// The whole algorithm, for each message.
Outputs Pipeline::step() {
  while (!inbox_.empty() && !must_restart()) {
    Message message = std::move(inbox_.front());
    inbox_.pop_front();
    if (buffers_) buffer_message(message);
    const bool usable = input_.accept(message);                    // time guard and plausibility
    if (usable) store(message);                                    // into the histories, by stamp
    if (!usable || !std::holds_alternative<ImuSample>(message)) {  // the IMU is the clock
      if (auto status = input_.status_without_clock())
        out_.status.push_back(stamped(*std::move(status)));
      continue;
    }
    start();               // from a saved state, or a standstill: gravity, gyro bias and noise
    take_radar_answers();  // each at its tick + gpr.latency_budget
    take_states();         // each at its time + time.reorder_window + smoother.latency
    take_map_answers();    // each at its query + graph.latency
    ask_radar();           // every gpr.tick
    make_states();         // every 1 / smoother.state_rate, once the reorder window has passed
    publish();             // the newest state in effect, propagated to now by the IMU
  }
  for (std::string& warning : health_.take_warnings()) out_.warnings.push_back(std::move(warning));
  return std::exchange(out_, {});
}

Pipeline::Pipeline(const Config& config, Execution execution, const gpr::FrontEndFactory& front_end,
                   StartingPoint start)
    : config_(config),
      execution_(execution),
      reorder_window_(from_seconds(config.time.reorder_window)),
      state_period_(from_seconds(1 / config.smoother.state_rate)),
      tick_period_(from_seconds(config.gpr.tick)),
      imu_mounting_(config.imu),
      health_(config.logging.warning_period),
      input_(config_, health_),
      motion_(config),
      ground_format_(start.ground ? start.ground->known_format() : std::nullopt),
      ground_of_(std::move(start.ground_of)),
      finds_mounting_(!config.imu.rpy_body_imu.rpy),
      search_(!finds_mounting_),
      begins_at_(start.begins_at),
      slip_drift_(config),
      antenna_filter_(config.gpr.filter),
      radar_(config.gpr, front_end),
      solver_(execution),
      radar_worker_(execution),
      has_earlier_ground_(start.ground && !start.ground->places.empty()),
      map_(std::make_unique<MapTask>(config, execution, std::move(start.ground))) {
  check_consistency(config);
  if (config.state.map == MapUse::kReadOnly && map_->enabled()) health_.value("map.read_only", 1.0);
  imu_mounting_.divide_forces(start.accel_scale);
  find_mounting(start);
  earlier_pair_ = start.pair;
  earlier_slip_ = start.slip;
  if (start.pair) motion_.resume_pair(*start.pair);
  if (start.slip) motion_.resume_slip(*start.slip);
  saved_ = std::move(start.state);
  if (saved_ && saved_->wheel_m) motion_.resume_wheel({saved_->state.time, *saved_->wheel_m});
}

void Pipeline::store(Message& message) {
  if (auto* imu = std::get_if<ImuSample>(&message)) {
    imu_now_ = input_.imu_now();
    if (solver_.waiting() >= kMostSolves) {
      health_.count("smoother", "IMU sample dropped: the solver is a minute late");
      return;
    }
    if (!motion_.add(imu_mounting_.in_body(*imu)))
      health_.count(config_.channels.imu, "stamp repeated");
  } else if (auto* wheel = std::get_if<WheelSample>(&message)) {
    motion_.add(*wheel);
    count_jump();
  } else if (auto* wheels = std::get_if<WheelsSample>(&message)) {
    motion_.add(*wheels);
    count_jump();
  } else if (auto* trace = std::get_if<GprTrace>(&message)) {
    store_trace(std::move(*trace));
  } else if (auto* fix = std::get_if<PositionFix>(&message)) {
    health_.add("fixes.received", 1);
    if (!map_waits_) map_->add(*fix);
  } else {
    auto& displacement = std::get<Displacement>(message);
    if (displacement.kind == DisplacementKind::kRevisit) {
      if (!map_waits_) map_->add(displacement);
      return;
    }
    // Motion has no sign; any other kind is signed along the track.
    if (displacement.kind != DisplacementKind::kMotion)
      displacement.kind = DisplacementKind::kExternal;
    motion_.add_external(std::move(displacement));
  }
}

std::string Pipeline::add_factor(const UserFactor& factor) {
  std::string refusal = "the estimator has not started";
  if (started_)
    refusal = factors_.add(factor, next_state_ - state_period_ - from_seconds(config_.smoother.lag),
                           imu_now_ + TimeGuard::kMaxJump);
  if (!refusal.empty()) health_.count("factor " + factor.name, refusal);
  return refusal;
}

void Pipeline::count_jump() {
  if (!motion_.take_jump()) return;
  if (config_.wheel.max_speed > 0)
    health_.count(input_.wheel_channel(),
                  "beyond wheel.max_speed: the distance jumped, or the robot is faster than that");
  else
    health_.count(input_.wheel_channel(),
                  "distance jumped: the encoder was set back, or a count is wrong");
}

void Pipeline::start() {
  if (started_ || imu_now_ < next_start_try_) return;
  if (saved_ && resume()) return;
  if (next_start_try_ == 0) {  // the first data: wait until there can be enough
    next_start_try_ = imu_now_ + from_seconds(0.9 * config_.initializer.duration);
    health_.await("start", HealthLevel::kDegraded, "collecting initializer.duration of standstill");
    return;
  }
  next_start_try_ = imu_now_ + kSecond / 10;
  level_imu();
  if (imu_now_ < begins_at_) {
    next_start_try_ = std::min(next_start_try_, begins_at_);
    return;
  }
  auto [initial, refusal] = motion_.initialize(begins_at_ > 0);
  health_.set("start", HealthLevel::kDegraded, initial ? "" : refusal);
  if (!initial) return;
  imu_mounting_.divide_forces(initial->accel_scale);
  initial->accel_scale = imu_mounting_.accel_scale();  // with that of an earlier start
  begin(*initial, initial_result(*initial));
}

void Pipeline::begin(const InitialState& initial, const StateResult& first) {
  started_ = true;
  began_at_ = imu_now_;
  estimator_ = std::make_unique<StateEstimator>(config_, initial);
  if (record_) {
    estimator_->record();
    map_->record();
  }
  motion_.begin(first, initial);
  search_since(motion_.imu().oldest(), first.state);
  prediction_.rebase(first, initial.noise, motion_.wheel_contact(), motion_.imu());
  // The first interval is 0.5 to 1.5 periods long, or ends now.
  const TimeNs newest = std::max(first.state.time, imu_now_);
  next_state_ = next_multiple(newest + state_period_ / 2, state_period_);
}

void Pipeline::take_radar_answers() {
  health_.count("radar", radar_worker_.drop_late(imu_now_),
                "tick not answered within gpr.latency_budget");
  while (auto due = radar_worker_.next_due(imu_now_)) {
    for (const std::string& note : due->result.notes)
      health_.count(config_.channels.gpr_trace, note);
    for (const gpr::Passage& passage : due->result.passages) take_passage(passage, due->effective);
    if (due->result.pair) report_antennas(*due->result.pair);
    if (due->result.sfm) out_.sfm.push_back(stamped(std::move(*due->result.sfm)));
    for (const gpr::Finding& finding : due->result.findings) {
      if (const auto* sight = std::get_if<gpr::Sight>(&finding)) {
        motion_.add_sight(*sight);
        continue;
      }
      Displacement d = motion_.in_metres(finding);
      if (d.valid && !fault(d, config_).empty()) continue;
      d.time = due->effective;
      motion_.add_radar(finding, PlacedDisplacement(d, place_of(due->result.antenna)));
      out_.displacements.push_back(stamped(std::move(d)));
    }
  }
}

void Pipeline::take_states() {
  while (auto due = solver_.next_due(imu_now_)) adopt(std::move(due->result), due->effective);
  health_.count("smoother", solver_.take_late(imu_now_),
                "solve not ready after smoother.latency: it counts later");
}

void Pipeline::take_map_answers() {
  while (auto answer = map_->next_due(imu_now_)) {
    for (const std::string& note : answer->notes) health_.count("map", note);
    if (map_->enabled())
      health_.add("revisits.found", static_cast<double>(answer->revisits.size()));
    for (Displacement& d : answer->revisits) out_.displacements.push_back(stamped(std::move(d)));
    if (answer->map) map_number_ = *answer->map;
    if (answer->located) {
      located_ = true;
      out_.warnings.emplace_back(
          "located on ground of an earlier track: map is its frame from now on");
    }
    if (answer->fixes) report_fixes(*answer->fixes);
    if (answer->tied) out_.warnings.emplace_back("tied to site by fixes: map is site from now on");
    report_place(*answer);
    if (!answer->pose || !map_->enabled()) continue;
    health_.value("revisits.trusted", answer->pose->revisits);
    health_.value("revisits.refused", answer->pose->refused);
  }
  const MapTask::Late late = map_->take_late(imu_now_);
  health_.count("map", late.answers, "answer not ready after graph.latency: it counts later");
  health_.count("map", late.joined,
                "input joined with later input: the map is slower than the robot");
  health_.count("map", late.dropped, "trace or revisit dropped: the map is slower than the robot");
}

void Pipeline::adopt(StateResult result, TimeNs effective) {
  const ImuNoise noise = motion_.noise(result.state.time, imu_now_);
  const bool measured = motion_.measured_by_pair();
  if (measured)
    slip_drift_.measured(result.state, noise, motion_.slip_share());
  else
    slip_drift_.advance(result.state, noise, motion_.slip_share(), motion_.slip_left());
  slip_drift_.measure(result.place_information);
  result.unmeasured_slip_sigma = slip_drift_.sigma();
  result.slip_sigma = measured ? 0.0 : slip_drift_.sigma();
  if (result.settled) result.settled_slip_by_pair = motion_.slip_left_by_pair(result.settled->time);
  lost_heading_.advance(result.state, result.covariance(row::kTheta + 2, row::kTheta + 2));
  result.unmodelled_covariance = slip_drift_.covariance() + lost_heading_.covariance();
  const Eigen::Vector3d before = prediction_.position();
  prediction_.rebase(result, noise, motion_.wheel_contact(), motion_.imu());
  motion_.adopt(result);
  if (!map_waits_) map_->add(result, effective);
  keep_way(result);

  health_.value("wheel.unwitnessed", result.slip_sigma);
  if (motion_.wheel_delay_s() > 0) health_.value("wheel.delay_s", motion_.wheel_delay_s());
  if (motion_.wheel_position().learns()) {
    health_.value("wheel.y_m", motion_.wheel_position().learnt().y_m);
    health_.value("wheel.y_sigma_m", motion_.wheel_position().learnt().sigma_m);
  }
  health_.add("states", 1);
  health_.add("solver.steps", result.solve.steps);
  health_.add("solver.steps_accepted", result.solve.accepted);
  health_.add("displacements.used", result.displacements_used);
  health_.add("displacements.dropped", result.displacements_dropped);
  if (result.factors_used > 0) health_.add("factors.used", result.factors_used);
  for (const auto& [factor, reason] : result.refused) health_.count("factor " + factor, reason);
  health_.maximum("odom.largest_jump_m", (prediction_.position() - before).norm());
  if (result.solve.unfounded) health_.count("smoother", "information gained without a measurement");
  health_.set("smoother", HealthLevel::kDegraded,
              result.solve.usable ? "" : "the last solve failed; the last good state is kept");
}

void Pipeline::ask_radar() {
  if (!radar_.enabled()) return;
  if (next_tick_ == 0 || imu_now_ > next_tick_ + kSecond)  // at the start, and after a gap
    next_tick_ = next_multiple(imu_now_, tick_period_);
  while (imu_now_ >= next_tick_) {
    // In order for each antenna, but not from one to another.
    const auto end = std::stable_partition(traces_.begin(), traces_.end(),
                                           [&](const GprTrace& t) { return t.time <= next_tick_; });
    std::vector<GprTrace> batch(std::make_move_iterator(traces_.begin()),
                                std::make_move_iterator(end));
    traces_.erase(traces_.begin(), end);
    radar_worker_.submit(
        next_tick_ + from_seconds(config_.gpr.latency_budget),
        [this, tick = next_tick_, batch = std::move(batch), antenna = input_.followed().value_or(0),
         path = travel(),
         trigger = input_.trigger()] { return radar_.run(batch, tick, antenna, path, trigger); });
    next_tick_ += tick_period_;
  }
}

void Pipeline::make_states() {
  const double most = std::max(1.0, kMostBehind * config_.smoother.state_rate);
  const TimeNs longest = from_seconds(std::min(kLongestInterval, 0.5 * config_.smoother.lag));
  for (; started_ && imu_now_ >= next_state_ + reorder_window_; next_state_ += state_period_) {
    const bool may_wait = next_state_ + state_period_ <= motion_.judged_to() + longest;
    if (may_wait && static_cast<double>(solver_.waiting()) >= most) {
      health_.count("smoother", "state left out: the solver is slower than smoother.state_rate");
      continue;
    }
    const auto turned_axes = take_mounting();
    StateInput input = motion_.judge(next_state_);
    input.turned_axes = turned_axes;
    if (input.speed_correction)
      health_.count(input_.wheel_channel(), "the estimated speed was wrong and is corrected");
    if (input.gyro_bias)
      health_.count(config_.channels.imu,
                    "gyro bias has changed: heading uncertain since the last standstill");
    health_.set("gyro", HealthLevel::kDegraded,
                motion_.turns_at_rest()
                    ? "a steady turn while all other sensors show a standstill: its bias has "
                      "changed, or the robot is turned on the spot"
                    : "");
    watch_mounting(input);
    input.factors = factors_.take(next_state_);
    if (const auto since = gpr::PairFrontEnd::begin_of_next(config_.gpr, travel_))
      input.keep_since = std::min(*since, input.keep_since.value_or(*since));
    const TimeNs effective = next_state_ + reorder_window_ + from_seconds(config_.smoother.latency);
    solver_.submit(effective, [this, input = std::move(input)] { return estimator_->add(input); });
  }
}

void Pipeline::publish() {
  if (started_ && imu_now_ > prediction_.time())
    publish_pose(prediction_.advance(motion_.imu(), imu_now_));
  if (imu_now_ < next_status_) return;
  if (next_status_ > 0) {
    input_.watch_silence(radar_.enabled());
    report_accelerometer();
    report_pair();
    report_trigger();
    report_sight();
    report_slip();
    out_.status.push_back(stamped(health_.status(imu_now_)));
  }
  next_status_ = next_multiple(imu_now_, kSecond);
}

Displacement Pipeline::stamped(Displacement displacement) const {
  for (TimeNs* time : {&displacement.time, &displacement.from, &displacement.to})
    *time = sensor_stamp(*time);
  return displacement;
}

void Pipeline::publish_pose(OdometryEstimate estimate) {
  if (prediction_.lost()) return;  // until there is a state after the gap
  if (motion_.follow(estimate))
    health_.count(input_.wheel_channel(), "slip: the wheel disagrees with the robot's motion");
  // After follow(): slip shows as a difference between the wheel and the IMU alone.
  const auto heard = motion_.wheel().newest(estimate.time - kOvertakes);
  const PredictedWay* way = heard ? prediction_.way(*heard) : nullptr;
  if (way != nullptr) {
    const auto wheel = motion_.wheel_since(prediction_.base().state.time, *way, *heard);
    if (wheel) prediction_.take_wheel(*way, *wheel, config_.wheel.robust_threshold, estimate);
  }
  if (input_.radar_silent()) estimate.flags |= kNoRadar;
  out_.odometry.push_back(stamped(estimate));
  if (auto correction = map_->correct(estimate)) out_.corrections.push_back(stamped(*correction));
}

Outputs Pipeline::finish() {
  Outputs out = step();
  drain();
  if (imu_now_ > 0) {
    input_.watch_silence(radar_.enabled());
    out.status.push_back(stamped(health_.status(imu_now_)));
  }
  return out;
}

}  // namespace gprodom
