#include "pipeline/pipeline.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <stdexcept>

#include "estimation/initializer.h"
#include "gprodom/error.h"
#include "input/plausibility.h"
#include "motion/standstill.h"

namespace gprodom {

namespace {

constexpr TimeNs kSecond = 1'000'000'000;

// Kept of the other sensors while no state is made: before the start, or without an IMU.
constexpr TimeNs kLongestSilence = 100 * kSecond;
constexpr std::size_t kMostWaiting = 2000;  // traces, or external displacements

// A solve takes milliseconds. On a machine that is busy beyond this the newest state waits.
constexpr std::chrono::milliseconds kSolverPatience(200);

// The first multiple of the period after a time: radar ticks and states share such a grid.
TimeNs next_multiple(TimeNs time, TimeNs period) { return (time / period + 1) * period; }

void check_consistency(const Config& config) {
  const SmootherConfig& c = config.smoother;
  if (c.latency >= 1 / c.state_rate)
    throw ConfigError("smoother.latency: expected less than one state interval, 1 / state_rate");
  if (c.lag < 2 / c.state_rate)
    throw ConfigError("smoother.lag: expected at least two state intervals, 2 / state_rate");
  if (config.graph.enabled && config.graph.settle >= c.lag)
    throw ConfigError("graph.settle: expected less than smoother.lag");
}

}  // namespace

// The whole algorithm: the life of one message.
Outputs Pipeline::step() {
  while (!inbox_.empty() && !must_restart()) {
    Message message = std::move(inbox_.front());
    inbox_.pop_front();
    const bool usable = input_.accept(message);                    // time guard and plausibility
    if (usable) store(message);                                    // into the histories, by stamp
    if (!usable || !std::holds_alternative<ImuSample>(message)) {  // the IMU is the clock
      if (auto status = input_.status_without_clock()) out_.status.push_back(*std::move(status));
      continue;
    }
    start();               // from a saved state, or a standstill: gravity, gyro bias and noise
    take_radar_answers();  // each at its tick + gpr.latency_budget
    take_states();         // each at its time + time.reorder_window + smoother.latency
    take_map_answers();    // each at its question + graph.latency
    ask_radar();           // every gpr.tick
    make_states();         // every 1 / smoother.state_rate, once the reorder window has passed
    publish();             // the newest state in effect, carried to now by the IMU
  }
  for (std::string& warning : health_.take_warnings()) out_.warnings.push_back(std::move(warning));
  return std::exchange(out_, {});
}

Pipeline::Pipeline(const Config& config, Execution execution, Heritage heritage)
    : config_(config),
      execution_(execution),
      reorder_window_(from_seconds(config.time.reorder_window)),
      state_period_(from_seconds(1 / config.smoother.state_rate)),
      tick_period_(from_seconds(config.gpr.tick)),
      R_body_imu_((Eigen::AngleAxisd(config.imu.rpy_body_imu.z(), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(config.imu.rpy_body_imu.y(), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(config.imu.rpy_body_imu.x(), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix()),
      health_(config.logging.warning_period),
      input_(config_, health_),
      wheel_(config.wheel.max_speed),
      prediction_(config.initializer.gravity, from_seconds(config.time.imu_gap)),
      slip_(config.wheel),
      coherence_(config.gpr.coherence),
      radar_(config.gpr),
      solver_(execution),
      radar_worker_(execution),
      ground_from_before_(heritage.ground && !heritage.ground->places.empty()),
      map_(std::make_unique<MapTask>(config, execution, std::move(heritage.ground))) {
  check_consistency(config);
  saved_ = std::move(heritage.state);
  if (saved_ && saved_->wheel_m) wheel_.resume({saved_->state.time, *saved_->wheel_m});
}

void Pipeline::store(Message& message) {
  if (auto* imu = std::get_if<ImuSample>(&message)) {
    imu->acceleration = R_body_imu_ * imu->acceleration;
    imu->angular_velocity = R_body_imu_ * imu->angular_velocity;
    if (!imu_.insert(*imu)) health_.count(config_.channels.imu, "stamp repeated");
    imu_now_ = input_.imu_now();
  } else if (auto* wheel = std::get_if<WheelSample>(&message)) {
    wheel_.forget_before(input_.wheel_now() - kLongestSilence);
    if (config_.wheel.enabled && !wheel_.insert(*wheel))
      health_.count(config_.channels.wheel, "distance jumped: beyond wheel.max_speed");
  } else if (auto* trace = std::get_if<GprTrace>(&message)) {
    if (!config_.gpr.enabled) return;
    map_->add(*trace);
    if (radar_.enabled() && traces_.size() < kMostWaiting) traces_.push_back(std::move(*trace));
  } else {
    auto& displacement = std::get<Displacement>(message);
    if (displacement.kind == DisplacementKind::kRevisit) {
      map_->add(displacement);
      return;
    }
    displacement.kind = DisplacementKind::kExternal;  // whatever its sender calls it
    if (new_displacements_.size() < kMostWaiting)
      new_displacements_.push_back(std::move(displacement));
  }
}

void Pipeline::start() {
  if (started_ || imu_now_ < next_start_try_) return;
  if (saved_ && resume()) return;
  if (next_start_try_ == 0) {  // the first data: no use to ask before there can be enough
    next_start_try_ = imu_now_ + from_seconds(0.9 * config_.initializer.duration);
    health_.await("start", HealthLevel::kDegraded, "collecting initializer.duration of standstill");
    return;
  }
  next_start_try_ = imu_now_ + kSecond / 10;
  const TimeNs from = imu_now_ - from_seconds(config_.initializer.duration);
  imu_.forget_before(from);
  auto [initial, refusal] =
      initialize(config_, imu_.between(from, imu_now_), wheel_.path(from, imu_now_));
  health_.set("start", HealthLevel::kDegraded, initial ? "" : refusal);
  if (!initial) return;

  begin(*initial);
  prediction_.rebase(initial_result(*initial), initial->noise, imu_);
}

void Pipeline::begin(const InitialState& initial) {
  started_ = true;
  estimator_ = std::make_unique<StateEstimator>(config_, initial);
  if (record_) {
    estimator_->record();
    map_->record();
  }
  reference_noise_ = initial.noise;
  newest_state_ = initial.state.time;
  // The first interval is a half to one and a half periods long, or reaches to now.
  next_state_ = next_multiple(std::max(newest_state_, imu_now_) + state_period_ / 2, state_period_);
}

void Pipeline::take_radar_answers() {
  while (auto due = radar_worker_.next_due(imu_now_)) {
    if (!due->result) {
      health_.count("radar", "tick not answered within gpr.latency_budget");
      continue;
    }
    for (const std::string& note : due->result->notes)
      health_.count(config_.channels.gpr_trace, note);
    if (due->result->sfm) out_.sfm.push_back(std::move(*due->result->sfm));
    for (Displacement& d : due->result->displacements) {
      if (d.source == "coherence") d = coherence_.to_metres(d);
      if (d.valid && !fault(d, config_).empty()) continue;
      if (d.valid && d.source == "coherence")
        slip_.hear(d, wheel_, prediction_.base().state.wheel_scale);
      d.time = due->effective;
      out_.displacements.push_back(d);
      const bool standing = d.kind == DisplacementKind::kMotion && d.distance_m == 0.0;
      if (d.valid) (standing ? radar_standing_ : new_displacements_).push_back(d);
    }
  }
  const TimeNs old = imu_now_ - 2 * kSecond;
  radar_standing_.erase(std::remove_if(radar_standing_.begin(), radar_standing_.end(),
                                       [&](const Displacement& d) { return d.to < old; }),
                        radar_standing_.end());
}

void Pipeline::take_states() {
  while (auto due = solver_.await_due(imu_now_, kSolverPatience)) {
    if (!due->result) {
      health_.count("smoother", "solve not ready after smoother.latency");
      break;
    }
    use(*due->result, due->effective);
  }
}

void Pipeline::take_map_answers() {
  while (auto answer = map_->next_due(imu_now_)) {
    for (const std::string& note : answer->notes) health_.count("map", note);
    health_.add("revisits.found", static_cast<double>(answer->revisits.size()));
    for (Displacement& d : answer->revisits) out_.displacements.push_back(std::move(d));
    if (answer->map) map_number_ = *answer->map;
    if (answer->located) {
      located_ = true;
      out_.warnings.emplace_back("located on ground of before: map is its frame from here on");
    }
    if (ground_from_before_) health_.value("map.located", located_ ? 1.0 : 0.0);
    if (!answer->pose) continue;
    health_.value("revisits.trusted", answer->pose->revisits);
    health_.value("revisits.refused", answer->pose->refused);
  }
}

void Pipeline::use(const StateResult& result, TimeNs effective) {
  const ImuNoise noise =
      config_.imu.adaptive_noise
          ? prevailing_noise(imu_.between(result.state.time, imu_now_), reference_noise_)
          : reference_noise_;
  const Eigen::Vector3d before = prediction_.position();
  prediction_.rebase(result, noise, imu_);
  imu_.forget_before(std::min(newest_state_, result.state.time) - kSecond);
  wheel_.forget_before(newest_state_ - SlipWatch::kMemory);
  map_->add(result, effective);

  health_.add("states", 1);
  health_.add("solver.steps", result.solve.steps);
  health_.add("solver.steps_accepted", result.solve.accepted);
  health_.add("displacements.used", result.displacements_used);
  health_.add("displacements.dropped", result.displacements_dropped);
  health_.maximum("odom.largest_jump_m", (prediction_.position() - before).norm());
  health_.set("smoother", HealthLevel::kDegraded,
              result.solve.usable ? "" : "the last solve failed; the last good state stands");
}

void Pipeline::ask_radar() {
  if (!radar_.enabled()) return;
  if (next_tick_ == 0 || imu_now_ > next_tick_ + kSecond)  // at the start, and after a gap
    next_tick_ = next_multiple(imu_now_, tick_period_);
  while (imu_now_ >= next_tick_) {
    const auto end = std::partition_point(traces_.begin(), traces_.end(),
                                          [&](const GprTrace& t) { return t.time <= next_tick_; });
    std::vector<GprTrace> batch(std::make_move_iterator(traces_.begin()),
                                std::make_move_iterator(end));
    traces_.erase(traces_.begin(), end);
    radar_worker_.submit(
        next_tick_ + from_seconds(config_.gpr.latency_budget),
        [this, tick = next_tick_, batch = std::move(batch)] { return radar_.run(batch, tick); });
    next_tick_ += tick_period_;
  }
}

void Pipeline::make_states() {
  while (started_ && imu_now_ >= next_state_ + reorder_window_) {
    StateInput input = collect(newest_state_, next_state_);
    const TimeNs effective = next_state_ + reorder_window_ + from_seconds(config_.smoother.latency);
    solver_.submit(effective, [this, input = std::move(input)] { return estimator_->add(input); });
    newest_state_ = next_state_;
    next_state_ += state_period_;
  }
}

StateInput Pipeline::collect(TimeNs from, TimeNs to) {
  StateInput input;
  input.time = to;
  input.steps = imu_.steps(from, to, from_seconds(config_.time.imu_gap));
  const TimeNs margin = state_period_ / 2;  // more samples for the same noise
  input.noise = config_.imu.adaptive_noise
                    ? prevailing_noise(imu_.between(from - margin, to + margin), reference_noise_)
                    : reference_noise_;
  // Where both are silent how the way was covered is not known, but how long it was is.
  const auto around = imu_.steps(from - state_period_, to, from_seconds(config_.time.imu_gap));
  const bool imu_gap = std::any_of(around.begin(), around.end(),
                                   [](const MotionStep& step) { return step.bridged; });
  input.has_wheel = add_wheel(input.steps, wheel_, from, imu_gap);
  const StandstillVerdict verdict =
      judge_standstill(config_, reference_noise_, prediction_.base().state.gyro_bias, imu_, wheel_,
                       radar_standing_, from, to);
  input.standing = verdict.standing;
  input.speed_word = slip_.word(from, wheel_, prediction_.base().state.wheel_scale);
  if (input.speed_word) {
    health_.count(config_.channels.wheel, "the speed held for right was not");
    speed_known_ = to + from_seconds(config_.smoother.lag);
  }
  input.wheel_contradicted = verdict.wheel_contradicted || slip_.between(from, to);
  input.gyro_bias = bias_watch_.moved(verdict, to_seconds(to - from));
  if (input.gyro_bias) {
    input.standing = true;
    health_.count(config_.channels.imu,
                  "gyro bias had moved: heading lost since the last standstill");
  }
  // An answer may come before the state that it reaches to, which waits for the reorder window.
  const auto later = std::stable_partition(new_displacements_.begin(), new_displacements_.end(),
                                           [to](const Displacement& d) { return d.to <= to; });
  if (!input.has_wheel || input.wheel_contradicted) wheel_doubted_ = to;
  std::copy_if(new_displacements_.begin(), later, std::back_inserter(input.displacements),
               [this](const Displacement& d) { return wanted(d); });
  new_displacements_.erase(new_displacements_.begin(), later);
  return input;
}

// Beside a wheel that can be used the coherence has nothing to add: it learns from it.
bool Pipeline::wanted(const Displacement& d) const {
  if (d.kind != DisplacementKind::kMotion) return true;
  const std::string& use = config_.gpr.coherence.use;
  return use == "always" || (use == "contradicted" && d.from < wheel_doubted_);
}

std::int32_t Pipeline::flags() const {
  const StateResult& base = prediction_.base();
  std::int32_t f = 0;
  if (base.standing) f |= kStanding;
  if (slip_.now() != WheelSlip::kNone)
    f |= kSlipping | (slip_.now() == WheelSlip::kFast ? kWheelFast : kWheelSlow);
  if (base.no_wheel) f |= kNoWheel;
  if (input_.radar_silent()) f |= kNoRadar;
  if (base.bridged) f |= kImuGap;
  if (!base.solve.usable) f |= kSolverFailed;
  return f;
}

void Pipeline::publish() {
  if (started_ && imu_now_ > prediction_.time()) publish_pose(prediction_.advance(imu_, imu_now_));
  if (imu_now_ < next_status_) return;
  if (next_status_ > 0) {
    input_.watch_silence(radar_.enabled());
    out_.status.push_back(health_.status(imu_now_));
  }
  next_status_ = next_multiple(imu_now_, kSecond);
}

void Pipeline::publish_pose(OdometryEstimate estimate) {
  if (prediction_.lost()) return;  // until a state beyond the gap has been carried there
  // After a gap of the IMU the speed is a guess, or the wheel's: no witness against the wheel.
  const StateResult& base = prediction_.base();
  if (base.carried) speed_known_ = base.state.time + from_seconds(config_.smoother.lag);
  const bool speed_known = estimate.time > speed_known_;
  if (!base.bridged) {
    const bool slipped = slip_.now() != WheelSlip::kNone;
    slip_.add(estimate, wheel_, input_.wheel_now(), speed_known);
    if (!slipped && slip_.now() != WheelSlip::kNone)
      health_.count(config_.channels.wheel, "turns otherwise than the robot moves");
  }
  estimate.flags = flags();
  coherence_.add(estimate, speed_known);
  out_.odometry.push_back(estimate);
  if (auto correction = map_->correct(estimate)) out_.corrections.push_back(*correction);
}

Outputs Pipeline::finish() {
  Outputs out = step();
  drain();
  if (imu_now_ > 0) {
    input_.watch_silence(radar_.enabled());
    out.status.push_back(health_.status(imu_now_));
  }
  return out;
}

const Batch& Pipeline::batch() const {
  if (!estimator_ || !estimator_->recorded())
    throw std::runtime_error("nothing recorded: call record() first, and let the robot start");
  return *estimator_->recorded();
}

// The batch with the revisits that the map rests on.
std::vector<NavState> Pipeline::smoothed() const {
  Batch batch = this->batch();
  const std::vector<NavState>& states = batch.states();
  const auto state_at = [&](TimeNs time) {
    const auto found = std::partition_point(states.begin(), states.end(),
                                            [time](const NavState& x) { return x.time < time; });
    return static_cast<size_t>(found - states.begin());
  };
  for (const Revisit& revisit : map_->revisits()) {
    const size_t memory = state_at(revisit.memory), query = state_at(revisit.query);
    if (memory < query && query < states.size())
      batch.add_factor(memory, query, std::make_shared<RevisitFactor>(revisit.edge));
  }
  // In map, which is not odom's frame where the track lies on ground from before.
  const PlanarPose map_from_odom = map_->map_from_odom();
  const Eigen::Quaterniond q(Eigen::AngleAxisd(map_from_odom.yaw, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d p(map_from_odom.p.x(), map_from_odom.p.y(), 0.0);
  std::vector<NavState> solved = batch.solve({});
  for (NavState& x : solved) {
    x.p_odom = q * x.p_odom + p;
    x.q_odom_body = q * x.q_odom_body;
  }
  return solved;
}

}  // namespace gprodom
