#include "map/map_task.h"

#include <cmath>
#include <iterator>
#include <utility>

#include "map/map_frame.h"

namespace gprodom {
namespace {

constexpr TimeNs kJobPeriod = 500'000'000;
constexpr std::size_t kMostWaiting = 2000;  // traces or revisits that wait for a state

// Inputs of a mapper that is late are joined as far as the path knows its recent states (MapPath:
// 20 s), and no more than so many of these wait: 100 s of data, which the search of all ground of
// a large map can take.
constexpr TimeNs kLongestInput = 10'000'000'000;
constexpr std::size_t kMostInputs = 10;

template <class T>
void append(std::vector<T> more, std::vector<T>& to) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

void move_until(TimeNs newest, std::deque<GprTrace>& from, std::vector<GprTrace>& to) {
  for (; !from.empty() && from.front().time <= newest; from.pop_front())
    to.push_back(std::move(from.front()));
}

void append(MapInput later, MapInput& to) {
  append(std::move(later.states), to.states);
  append(std::move(later.traces), to.traces);
  append(std::move(later.beside), to.beside);
  append(std::move(later.revisits), to.revisits);
  append(std::move(later.fixes), to.fixes);
  if (later.told) to.told = later.told;
  to.scale = later.scale;
  to.scale_sigma = later.scale_sigma;
}

void append(MapAnswer later, MapAnswer& to) {
  later.revisits.swap(to.revisits);
  append(std::move(to.revisits), later.revisits);
  later.notes.swap(to.notes);
  append(std::move(to.notes), later.notes);
  later.located |= to.located;
  later.tied |= to.tied;
  if (!later.pose) later.pose = to.pose;
  if (!later.fixes) later.fixes = to.fixes;
  if (!later.map) later.map = to.map;
  to = std::move(later);
}

// Whether they place the robot a fifth of a standard deviation apart: what odom has jumped by.
bool differ(const Correction& one, const Correction& other, const OdometryEstimate& now) {
  constexpr double kWorthTelling = 0.2;
  const Eigen::Vector3d apart = one.q_map_odom * now.p_odom_body + one.p_map_odom -
                                (other.q_map_odom * now.p_odom_body + other.p_map_odom);
  const double variance = other.covariance.topLeftCorner<2, 2>().trace();
  return apart.squaredNorm() > kWorthTelling * kWorthTelling * variance;
}

}  // namespace

Correction correction_by(const MapPose& settled, const OdometryEstimate& now) {
  const double yaw = settled.in_map.pose.yaw - settled.in_odom.pose.yaw;
  const Eigen::Rotation2Dd turn(yaw);
  const Eigen::Vector2d here = now.p_odom_body.head<2>();
  const double longer =
      std::exp(settled.in_map.slip) * settled.in_odom.scale / settled.in_map.scale;
  const Eigen::Vector2d in_map =
      settled.in_map.pose.p + longer * (turn * (here - settled.in_odom.pose.p));
  Correction correction;
  correction.time = now.time;
  correction.q_map_odom = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  correction.p_map_odom << in_map - turn * here, 0.0;
  correction.revisits = settled.revisits;
  correction.covariance = now.pose_covariance;
  const Eigen::Matrix3d planar =
      carried_covariance(correction, settled.in_map.covariance.topLeftCorner<3, 3>(),
                         planar_estimate(settled.in_odom), now);
  set_planar_block(planar, correction.covariance);
  return correction;
}

MapTask::MapTask(const Config& config, Execution execution, std::optional<GroundMap> before,
                 std::optional<TrackStart> start)
    : enabled_(config.gpr.enabled && config.graph.enabled),
      follows_(config.graph.enabled && (config.gpr.enabled || config.anchor.enabled)),
      uses_fixes_(config.graph.enabled && config.anchor.enabled),
      taken_from_(before ? before->taken_from() : 0),
      latency_(from_seconds(config.graph.latency)),
      mapper_(config, std::move(before), std::move(start)),
      worker_(execution) {}

void MapTask::add(const GprTrace& trace) {
  if (!enabled_) return;
  traces_.push_back(trace);
  if (traces_.size() <= kMostWaiting) return;
  traces_.pop_front();
  if (!unsettled_.empty()) ++late_.dropped;  // before the start, none is kept for the map
}

void MapTask::add_beside(const GprTrace& trace) {
  if (!enabled_) return;
  beside_.push_back(trace);
  if (beside_.size() > kMostWaiting) beside_.pop_front();
}

template <class T>
void MapTask::keep(const T& item, std::vector<T>& waiting) {
  if (waiting.size() < kMostWaiting)
    waiting.push_back(item);
  else
    ++late_.dropped;
}

void MapTask::add(const Displacement& revisit) {
  if (enabled_) keep(revisit, next_.revisits);
}

void MapTask::add(const PositionFix& fix) {
  if (uses_fixes_) keep(fix, next_.fixes);
}

void MapTask::add(const StateResult& result, TimeNs effective) {
  if (!follows_) return;
  unsettled_.push_back(path_state(result));
  if (!result.settled) return;
  while (!unsettled_.empty() && unsettled_.front().time < result.settled->time) {
    unsettled_.pop_front();
  }
  if (unsettled_.empty() || unsettled_.front().time != result.settled->time) return;
  settle(unsettled_.front(), result, settled_);
  settled_ = unsettled_.front();
  may_have_jumped_ = true;
  next_.states.push_back(unsettled_.front());
  unsettled_.pop_front();
  next_.scale = result.state.wheel_scale;
  next_.scale_sigma = std::sqrt(result.covariance(row::kScale, row::kScale));
  if (effective - last_submitted_ < kJobPeriod) return;
  last_submitted_ = effective;
  const TimeNs newest = next_.states.back().time;
  move_until(newest, traces_, next_.traces);
  move_until(newest, beside_, next_.beside);
  submit(effective, {{std::exchange(next_, {})}, {}, {}});
}

void MapTask::save_ground(TimeNs now, bool main, std::function<void(SavedGround)> take) {
  const auto save = [this, main, take = std::move(take)] { take(mapper_.saved_ground(main)); };
  submit(now, {{}, {save}, {}});
}

void MapTask::save_newest(TimeNs now, std::function<void(SavedGround)> take) {
  const auto save = [this, take = std::move(take)] { take(mapper_.newest_ground()); };
  submit(now, {{}, {}, save});
}

// If the mapper is so late that a job has not begun when its answer is due, all jobs that wait are
// done as one.
void MapTask::submit(TimeNs now, Work work) {
  for (std::size_t n = worker_.withdraw_late(now); n > 0; --n) {
    work = joined(std::move(*submitted_.back()), std::move(work));
    submitted_.pop_back();
  }
  const auto job = std::make_shared<Work>(std::move(work));
  worker_.submit(now + latency_, [this, job] { return run(*job); });
  submitted_.push_back(job);
  while (submitted_.size() > worker_.waiting()) submitted_.pop_front();
}

MapTask::Work MapTask::joined(Work earlier, Work later) {
  std::vector<MapInput>& inputs = earlier.inputs;
  if (!inputs.empty() && !later.inputs.empty()) ++late_.joined;
  for (MapInput& input : later.inputs) {
    if (inputs.empty() ||
        input.states.back().time - inputs.back().states.front().time > kLongestInput) {
      inputs.push_back(std::move(input));
    } else {
      append(std::move(input), inputs.back());
    }
  }
  for (; inputs.size() > kMostInputs; inputs.erase(inputs.begin())) {
    late_.dropped +=
        inputs.front().traces.size() + inputs.front().revisits.size() + inputs.front().fixes.size();
    if (!inputs[1].told) inputs[1].told = inputs.front().told;
  }
  append(std::move(later.savings), earlier.savings);
  if (later.newest) earlier.newest = std::move(later.newest);
  return earlier;
}

MapAnswer MapTask::run(const Work& work) {
  MapAnswer answer;
  answer.travelled_m = travelled_m_;
  answer.sigma_m = sigma_m_;
  try {
    for (const MapInput& input : work.inputs) append(mapper_.run(input), answer);
    travelled_m_ = answer.travelled_m;
    sigma_m_ = answer.sigma_m;
  } catch (const std::exception& error) {
    throw MapFailure(std::string("map: ") + error.what());
  } catch (...) {
    throw MapFailure("map: not a std::exception");
  }
  for (const auto& save : work.savings) save();
  if (work.newest) work.newest();
  return answer;
}

MapTask::Late MapTask::take_late(TimeNs now) {
  late_.answers += worker_.take_late(now);
  return std::exchange(late_, {});
}

GroundMap MapTask::take_ground() {
  drain();
  return mapper_.take_ground();
}

GroundMap MapTask::take_earlier_ground() {
  drain();
  return mapper_.take_earlier_ground();
}

SavedGround MapTask::saved_ground() {
  drain();
  return mapper_.saved_ground(false);
}

std::optional<MapAnswer> MapTask::next_due(TimeNs now) {
  auto due = worker_.next_due(now);
  if (!due) return std::nullopt;
  MapAnswer answer = std::move(due->result);
  for (Displacement& d : answer.revisits) d.time = due->effective;
  if (answer.pose) pose_ = answer.pose;
  is_new_ = is_new_ || answer.pose;
  return answer;
}

std::optional<Correction> MapTask::correct(const OdometryEstimate& estimate) {
  const bool asked = is_new_ || std::exchange(may_have_jumped_, false);
  if (!pose_ || !asked) return std::nullopt;
  MapPose settled = *pose_;
  if (settled_) settled.in_odom = seen_from(*settled_, settled.in_odom);
  const Correction correction = correction_by(settled, estimate);
  if (!std::exchange(is_new_, false) && corrected_ && !differ(*corrected_, correction, estimate))
    return std::nullopt;
  corrected_ = correction;
  return correction;
}

}  // namespace gprodom
