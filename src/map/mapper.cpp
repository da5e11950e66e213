#include "map/mapper.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "gprodom/version.h"
#include "map/ground_map_file.h"
#include "map/map_frame.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

constexpr double kConfirmWithin = 8.0;    // m driven without proof, then a hypothesis is dropped
constexpr double kAgainWithin = 24.0;     // m driven from a revisit without another, likewise
constexpr double kToldYawSigma = 0.15;    // rad; of a place told, as a hand sets it on a screen
constexpr double kSupposeEvery = 1.0;     // m between two choices of a change near a place told
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
      antenna_{config.gpr.lever_arm.head<2>(), 0.0},
      path_(kNodeSpacing),
      ground_(before ? std::move(*before) : GroundMap(memory_options(config))),
      end_of_before_(ground_.memory.kept().end),
      start_(std::move(start)),
      map_(ground_.unused_map()),
      fixes_(config.anchor),
      locator_(antenna_) {
  origin_ = {config.gpr.lever_arm, kVersion, config.state.robot, {}};
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
    search_memory(answer);
  }
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

void Mapper::remember(const GprTrace& trace, MapAnswer& answer) {
  const TraceFormat format = format_of(trace);
  if (ground_.format.samples != 0 && !same_format(ground_.format, format)) {
    answer.notes.push_back("trace of another length or interval than the ground's: not stored");
    return;
  }
  ground_.format = format;
  ground_.memory.add(trace.time, trace.samples, trace.sample_interval_s,
                     path_.distance_at(trace.time));
  last_trace_ = trace.time;
  note_origin();
}

// Of the path so far. What revisits and other tracks say of it is in its poses, not in this.
void Mapper::note_errors(double scale_sigma) {
  const double metres = step_variances_[0];
  if (metres < kNodeSpacing) return;
  origin_.errors = {std::sqrt(step_variances_[1] / metres), std::sqrt(step_variances_[2] / metres),
                    scale_sigma};
}

void Mapper::note_origin() {
  ground_.origins.resize(ground_.memory.sessions().size(), origin_);
  const std::size_t end = ground_.memory.kept().end;
  if (end <= end_of_before_ || end == noted_end_) return;
  ground_.extended(end_of_before_, last_trace_, noted_end_ == 0);
  noted_end_ = end;
  if (!ground_.origins.empty()) ground_.origins.back().errors = origin_.errors;
}

// A hypothesis as told, in place of a found one. Only a revisit proves it.
void Mapper::suppose(const ToldPlace& told, MapAnswer& answer) {
  std::map<int, std::size_t> places;
  for (const KnownPlace& place : ground_.places) ++places[place.map];
  const auto most =
      std::max_element(places.begin(), places.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const RoughPlace& place = told.place;
  const int map = place.map < 0 && most != places.end() ? most->first : place.map;
  if (located_) {
    answer.notes.emplace_back("locate_at: not used: the track is located already; reset first");
    return;
  }
  if (places.count(map) == 0) {
    answer.notes.emplace_back(
        "locate_at: not used: there is no earlier ground, or no map of that number");
    return;
  }
  const PlanarPose since = between(told.in_odom, path_.newest().pose);
  const PlanarPose in_map = compose({{place.x, place.y}, place.yaw}, since);
  Candidate candidate;
  candidate.at = {compose(in_map, between(newest_node_.pose, {})), map, {}};
  candidate.told_sigma_m = place.sigma_m;
  candidate.from_m = path_.travelled();
  candidate.until_m = candidate.from_m + kConfirmWithin + kGateSigmas * place.sigma_m;
  candidate_ = std::move(candidate);
  change_.believe({});
  forget_searches();
}

// Standard deviation of the position now, in the frame of the candidate if there is one.
double Mapper::sigma_m() const {
  const double odometry = std::sqrt(newest_node_.covariance.topLeftCorner<2, 2>().trace());
  if (!candidate_ || candidate_->told_sigma_m == 0.0) return odometry;
  const double turned = kToldYawSigma * (path_.travelled() - candidate_->from_m);
  return std::hypot(odometry, std::hypot(candidate_->told_sigma_m, turned));
}

// Until the track is located, searches all ground of earlier tracks.
void Mapper::locate(MapAnswer& answer) {
  const double travelled = path_.travelled();
  if (located_ || !locator_.is_due(travelled)) return;
  const bool was_told = candidate_ && candidate_->told_sigma_m > 0.0;
  if (candidate_ && travelled < candidate_->until_m) {
    if (was_told) suppose_change();
    return;
  }
  if (was_told)
    answer.notes.emplace_back(
        "locate_at: the ground there is not the one driven over: not located");
  candidate_.reset();
  const auto newest = Locator::last_searched(ground_.memory, end_of_before_);
  if (!newest) return;
  const MapPath::Place place = path_.place(newest->time, newest->distance_m);
  const PlanarPose body = body_at(place);
  const auto found = locator_.find(ground_, end_of_before_, body, travelled);
  if (!found) return;
  Candidate candidate;
  candidate.at = *found;
  candidate.from_m = travelled;
  candidate.until_m = travelled + kConfirmWithin;
  candidate_ = std::move(candidate);
  change_.believe(found->change);
  forget_searches();
}

// How the ground has changed is not told with a place. So the change that fits best near there is
// supposed, again and again, until the place is proved.
void Mapper::suppose_change() {
  const gpr::TraceMemory& memory = ground_.memory;
  if (!memory.can_undo() || path_.travelled() < candidate_->next_change_m) return;
  candidate_->next_change_m = path_.travelled() + kSupposeEvery;
  const Hypothesis& at = candidate_->at;
  const PlanarPose here = compose(at.map_from_track, newest_node_.pose);
  const double gate = std::min(kGateSigmas * sigma_m(), kGateMax);
  const auto best = Locator::change_near(ground_, end_of_before_, {at.map, here.p, gate});
  const gpr::TraceChange& now = change_.change();
  if (!best || (best->stretch == now.stretch && best->turn == now.turn)) return;
  change_.believe(*best);
  forget_searches();
}

// A place that was found is the best of a great many, and a drive over other ground tries many such
// places. So one revisit does not prove it: it needs another one whose patch has none of the
// ground of the first.
bool Mapper::is_proved() {
  if (candidate_->told_sigma_m > 0.0) return true;
  const double travelled = path_.travelled();
  if (!candidate_->supported_m) {
    candidate_->supported_m = travelled;
    candidate_->until_m = travelled + kAgainWithin;
  }
  return travelled - *candidate_->supported_m >= config_.patch_length;
}

// The track is located: from now on `map` is the frame of the earlier ground.
void Mapper::join_map(const Hypothesis& at) {
  if (tied_) {  // to site, and so is the ground now
    move_ground(at.map, between(at.map_from_track, {}));
  } else {
    graph_->move(at.map_from_track);
    move_newest(at.map_from_track);
  }
  map_ = at.map;
  moved_ = located_ = true;
  next_solve_ = 0;
}

// The memory's column at a node of this track; nothing if none is stored there.
std::optional<std::size_t> Mapper::column_at(std::size_t node) const {
  const auto column = ground_.memory.column_at(path_.time_of(node), end_of_before_);
  if (!column) return std::nullopt;
  const double apart = ground_.memory.column(*column).distance_m - path_.distance_of(node);
  return std::abs(apart) > kNodeSpacing ? std::nullopt : column;
}

PlanarPose Mapper::map_from_odom() const {
  if (!moved_) return {};
  return compose(graph_->nodes().front(), between(path_.first().pose, {}));
}

std::vector<KnownPlace> Mapper::places() const {
  // Only places whose ground is still stored.
  const std::size_t first = ground_.memory.kept().first;
  std::vector<KnownPlace> all;
  std::copy_if(ground_.places.begin(), ground_.places.end(), std::back_inserter(all),
               [first](const KnownPlace& place) { return place.column >= first; });
  const auto off = [this](const KnownPlace& place) {
    return std::abs(place.distance_m - ground_.memory.column(place.column).distance_m);
  };
  for (std::size_t node = 0; graph_ && node < path_.nodes(); ++node) {
    const auto column = column_at(node);
    if (!column) continue;
    const KnownPlace place{*column, path_.distance_of(node), graph_->nodes()[node], map_};
    // Where no ground is stored, several nodes have the run's last column: the nearest counts.
    if (all.empty() || all.back().column != *column) {
      all.push_back(place);
    } else if (off(place) < off(all.back())) {
      all.back() = place;
    }
  }
  return all;
}

SavedGround Mapper::saved_ground(bool main) {
  note_datum();
  SavedGround saved{to_bytes(ground_, places()), ground_.descent, !ground_.memory.filter(), 0};
  if (!main) return saved;
  const gpr::MemoryRange kept = ground_.memory.kept();
  // The run under way is forgotten if it ends before it is long enough.
  saved_ = {ground_head("ground", saved.bytes).identity, kept.first, kept.end};
  if (kept.size() > 0) {
    const gpr::MemoryRange run = ground_.memory.run_of(kept.end - 1);
    if (static_cast<double>(run.size()) * ground_.memory.spacing() <
        ground_.memory.options().least_m)
      saved_->end = run.first;
  }
  saved_end_ = kept.end;
  return saved;
}

SavedGround Mapper::newest_ground() {
  const gpr::MemoryRange kept = ground_.memory.kept();
  if (kept.end == saved_end_ || ground_.memory.sessions().empty()) return {};
  if (!saved_ || kept.first > saved_->end) return saved_ground(true);
  saved_end_ = kept.end;
  note_datum();
  return {newest_to_bytes(ground_, places(), end_of_before_, *saved_), ground_.descent, false,
          saved_->identity};
}

GroundMap Mapper::take_ground() {
  ground_.memory.end_run();
  note_origin();
  note_datum();
  ground_.places = places();
  return std::move(ground_);
}

GroundMap Mapper::take_earlier_ground() {
  GroundMap all = take_ground();
  const std::vector<gpr::MemoryRange> runs = all.runs();
  if (runs.empty() || runs.back().end <= end_of_before_) return all;
  std::vector<gpr::MemoryRange> earlier;
  for (const gpr::MemoryRange& run : runs)
    if (run.first < end_of_before_)
      earlier.push_back({run.first, std::min(run.end, end_of_before_)});
  return earlier.empty() ? GroundMap(all.memory.options()) : all.part(earlier);
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
  tied_at_m_ = std::max(tied_at_m_.value_or(at_m), at_m);
}

}  // namespace gprodom
