#include "map/mapper.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "gprodom/version.h"
#include "map/crowded_ground.h"
#include "map/map_frame.h"

namespace gprodom {
namespace {

constexpr double kSolveEvery = 1.0;       // s of data time, and
constexpr double kSolveEveryNode = 1e-3;  // s of data time a node, so that the work stays bounded
// Where the track has crossed itself again and again, a solution costs far more than by its nodes:
// it may take this much work (NormalMatrix::work()) for each second of data until the next one: a
// twentieth of a core that does 1e9 multiplications a second.
constexpr double kSolveWork = 5e7;
constexpr double kSolveAnyway = 10.0;  // s of data time; solves without a new revisit, since the
                                       // scale is learnt meanwhile

}  // namespace

gpr::TraceMemoryOptions memory_options(const Config& config) {
  gpr::TraceMemoryOptions options;
  options.filter.wave_speed = config.gpr.wave_speed;
  return options;
}

Mapper::Mapper(const Config& config, std::optional<GroundMap> before, std::optional<Start> start)
    : config_(config.graph),
      slip_(slip_model(config.wheel)),
      antennas_(config.gpr.antennas),
      lever_arm_(config.gpr.lever_arm),
      longest_arm_m_(lever_arm_.head<2>().norm()),
      path_(kNodeSpacing),
      ground_(before ? without_crowded(std::move(*before), config_.lateral_sigma)
                     : GroundMap(memory_options(config))),
      end_of_before_(ground_.memory.kept().end),
      first_session_(ground_.memory.sessions().size()),
      start_(std::move(start)),
      map_(ground_.unused_map()),
      fixes_(config.anchor) {
  seeker_.antenna = {lever_arm_.head<2>(), 0.0};
  origin_ = {lever_arm_, kVersion, config.state.robot, {}, 0};
  const auto reach = [this](const Eigen::Vector3d& antenna) {
    longest_arm_m_ = std::max(longest_arm_m_, antenna.head<2>().norm());
  };
  for (const auto& [id, antenna] : antennas_) reach(antenna);
  for (const SessionOrigin& origin : ground_.origins) reach(origin.antenna);
  ground_.memory.begin_session();
  saved_end_ = end_of_before_;
  take_datums();
  if (ground_.identity != 0) saved_ = SavedColumns{ground_.identity, 0, end_of_before_};
}

MapAnswer Mapper::run(const MapInput& input) {
  MapAnswer answer;
  const bool was_located = located_;
  follow(input.states);
  if (!graph_) return answer;
  note_errors(input.scale_sigma);
  external_.insert(external_.end(), input.revisits.begin(), input.revisits.end());
  take_external(answer);
  take_fixes(input, answer);
  if (input.told) suppose(*input.told, answer);
  for (const GprTrace& trace : input.traces) {
    remember(trace, answer);
    search_memory(seeker_, answer);
  }
  for (const GprTrace& trace : input.beside) look_beside(trace, answer);
  locate(answer);
  answer.located = located_ && !was_located;
  answer.map = map_;
  const bool more = graph_->revisits().size() > trusted_.size() || (tied_ && fixes_changed_);
  const bool moved = path_.travelled() > fresh_at_m_;  // else the last solution holds
  if ((tied_ || !graph_->revisits().empty()) && path_.nodes() > 1 &&
      path_.newest().time >= (more ? next_solve_ : solve_anyway_) && (more || moved)) {
    solve(input.scale, input.scale_sigma, answer);
    merge();
  } else if (more && path_.newest().time >= next_newest_) {
    solve_newest(answer);
  }
  const auto trusted = static_cast<int>(std::count(trusted_.begin(), trusted_.end(), true));
  const int refused = static_cast<int>(trusted_.size()) - trusted;
  if (fixes_.any()) answer.fixes = fix_report();
  if (solved_in_site_ || trusted + merged_trusted_ > 0) {
    answer.pose = MapPose{extend(newest_node_, path_.since_last_node(), slip_), path_.newest(),
                          trusted + merged_trusted_, refused + merged_refused_};
  }
  answer.travelled_m = path_.travelled();
  answer.sigma_m = sigma_m();
  return answer;
}

void Mapper::follow(const std::vector<PathState>& states) {
  for (const PathState& state : states) {
    const std::optional<PlanarStep> step = path_.add(state);
    if (!graph_) begin_graph(state);
    if (!step) continue;
    graph_->add_node(*step);
    const Eigen::Vector3d variances = step->covariance.diagonal();
    step_variances_ +=
        Eigen::Vector3d(step->measured.p.norm(), 0.5 * (variances[0] + variances[1]), variances[2]);
    newest_node_ = extend(newest_node_, *step, slip_);
  }
}

void Mapper::begin_graph(const PathState& first) {
  PoseGraphOptions options;
  options.slip = slip_;
  graph_.emplace(first.pose, options);
  newest_node_.pose = first.pose;
  if (!start_) return;
  join_map(start_->at);
  located_ = ground_.holds(map_);  // else its ground was never written
  Correction map_from_odom;
  const double yaw = start_->at.map_from_track.yaw;
  map_from_odom.q_map_odom = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  Eigen::Matrix3d covariance = carried_covariance(
      map_from_odom, start_->covariance, planar_estimate(start_->since), planar_estimate(first));
  // A pose is known no better than the origin of a track.
  const Eigen::Vector3d least(kOriginPositionSigma, kOriginPositionSigma, kOriginYawSigma);
  covariance.diagonal() += least.cwiseAbs2();
  graph_->set_first_prior(covariance);
  start_covariance_ = covariance;
  newest_node_.covariance.topLeftCorner<3, 3>() = covariance;
}

PlanarPose Mapper::map_from_odom() const {
  if (!moved_) return {};
  return compose(graph_->nodes().front(), between(path_.first().pose, {}));
}

void Mapper::solve(double scale, double scale_sigma, MapAnswer& answer) {
  double every =
      std::max(kSolveEvery, kSolveEveryNode * static_cast<double>(graph_->nodes().size()));
  fresh_at_m_ = path_.travelled() + kNodeSpacing;
  try {
    if (!tied_) graph_->set_fixes({});
    fixes_changed_ = false;
    const PoseGraphSolution solution = graph_->solve(scale, scale_sigma);
    newest_node_ = solution.newest;
    solved_in_site_ = tied_;
    trusted_ = solution.trusted;
    solve_work_ += solution.work;
    every = std::max(every, solution.work / kSolveWork);
    solved_to_m_ = path_.travelled_at(path_.nodes() - 1);
    solved_to_covariance_ = newest_node_.covariance.topLeftCorner<3, 3>();
    for (std::size_t i = 0; i < trusted_.size(); ++i)
      if (trusted_[i]) note_tie(i);
  } catch (const std::runtime_error& error) {
    answer.notes.emplace_back(error.what());
  }
  next_newest_ = path_.newest().time + from_seconds(kSolveEvery);
  next_solve_ = path_.newest().time + from_seconds(every);
  solve_anyway_ = path_.newest().time + from_seconds(std::max(kSolveAnyway, every));
}

// Of a large graph, solutions come seconds apart. Meanwhile revisits correct the nodes since the
// last one. The covariance stays that of dead reckoning, since the older nodes, which are held,
// have errors too.
void Mapper::solve_newest(MapAnswer& answer) {
  next_newest_ = path_.newest().time + from_seconds(kSolveEvery);
  if (trusted_.empty()) return;  // no solution yet
  std::size_t from = path_.nodes() - 1;
  while (from > 0 && path_.travelled_at(from) > solved_to_m_) --from;
  try {
    const auto solution = graph_->solve_newest(from, solved_to_covariance_);
    if (!solution) return;
    newest_node_.pose = solution->newest;
    newest_node_.slip = solution->slip;
    solve_work_ += solution->work;
    for (std::size_t revisit : solution->trusted) note_tie(revisit);
  } catch (const std::exception& error) {
    answer.notes.emplace_back(error.what());
  }
}

void Mapper::note_tie(std::size_t revisit) {
  const double at_m = path_.travelled_at(graph_->revisits()[revisit].query);
  if (tied_at_m_ && at_m <= *tied_at_m_) return;
  tied_at_m_ = at_m;
  tied_variance_m2_ = newest_node_.covariance.topLeftCorner<2, 2>().trace();
}

}  // namespace gprodom
