#include "map/mapper.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "gprodom/version.h"
#include "map/ground_map_file.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

constexpr double kConfirmWithin = 8.0;    // m driven without proof, then a hypothesis is dropped
constexpr double kAgainWithin = 24.0;     // m driven from a revisit without another, likewise
constexpr double kToldYawSigma = 0.15;    // rad; of a place told, as a hand sets it on a screen
constexpr double kSupposeEvery = 1.0;     // m between two choices of a change near a place told
constexpr double kLocatedWithin = 200.0;  // m driven, then known ground is no longer stored twice
constexpr double kSolveEvery = 1.0;       // s of data time, and
constexpr double kSolveEveryNode = 1e-3;  // s of data time a node, so that the work stays bounded
constexpr double kSolveAnyway = 10.0;     // s of data time; solves without a new revisit, since the
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
      locator_(antenna_) {
  origin_ = {config.gpr.lever_arm, kVersion, config.state.robot, {}};
  ground_.memory.begin_session();
}

MapAnswer Mapper::run(const MapInput& input) {
  MapAnswer answer;
  const bool was_located = located_;
  follow(input.states);
  if (!graph_) return answer;
  note_errors(input.scale_sigma);
  external_.insert(external_.end(), input.revisits.begin(), input.revisits.end());
  take_external(answer);
  if (input.told) suppose(*input.told, answer);
  for (const GprTrace& trace : input.traces) {
    remember(trace, answer);
    search_memory(answer);
  }
  locate(answer);
  answer.located = located_ && !was_located;
  answer.map = map_;
  const bool tied = graph_->revisits().size() > trusted_.size();
  if (!graph_->revisits().empty() && path_.newest().time >= (tied ? next_solve_ : solve_anyway_)) {
    solve(input.scale, input.scale_sigma, answer);
    merge();
  }
  const auto trusted = static_cast<int>(std::count(trusted_.begin(), trusted_.end(), true));
  const int refused = static_cast<int>(trusted_.size()) - trusted;
  if (trusted + merged_trusted_ > 0) {
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
    if (!graph_) {
      PoseGraphOptions options;
      options.slip = slip_;
      graph_.emplace(state.pose, options);
      newest_node_.pose = state.pose;
      if (start_) {
        join_map(start_->at);
        located_ = ground_.holds(map_);  // else its ground was never written
        newest_node_.covariance.topLeftCorner<3, 3>() = start_->covariance;
      }
    }
    if (!step) continue;
    graph_->add_node(*step);
    const Eigen::Vector3d variances = step->covariance.diagonal();
    step_variances_ +=
        Eigen::Vector3d(step->measured.p.norm(), 0.5 * (variances[0] + variances[1]), variances[2]);
    newest_node_ = extend(newest_node_, *step, slip_);
  }
}

void Mapper::remember(const GprTrace& trace, MapAnswer& answer) {
  const TraceFormat format = format_of(trace);
  if (ground_.format.samples != 0 && !same_format(ground_.format, format)) {
    ground_.memory.clear();
    ground_.places.clear();
    ground_.origins.clear();
    end_of_before_ = 0;
    hypothesis_.reset();
    search_.reset();
    search_before_.reset();
    change_ = ChangeFollower();
    last_query_.reset();
    answer.notes.push_back("traces of another length or interval: the stored ground is deleted");
  }
  ground_.format = format;
  ground_.memory.add(trace.time, trace.samples, trace.sample_interval_s,
                     path_.distance_at(trace.time));
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
  if (ground_.memory.kept().end <= end_of_before_) return;
  ground_.changes();
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
  hypothesis_ = Hypothesis{compose(in_map, between(newest_node_.pose, {})), map, {}};
  change_.believe({});
  next_change_m_ = 0.0;
  told_sigma_m_ = place.sigma_m;
  hypothesis_from_m_ = path_.travelled();
  hypothesis_until_m_ = hypothesis_from_m_ + kConfirmWithin + kGateSigmas * place.sigma_m;
  forget_searches();
}

// Standard deviation of the position now, in the frame of the hypothesis if there is one.
double Mapper::sigma_m() const {
  const double odometry = std::sqrt(newest_node_.covariance.topLeftCorner<2, 2>().trace());
  if (!hypothesis_ || told_sigma_m_ == 0.0) return odometry;
  const double turned = kToldYawSigma * (path_.travelled() - hypothesis_from_m_);
  return std::hypot(odometry, std::hypot(told_sigma_m_, turned));
}

// Until the track is located, searches all ground of earlier tracks.
void Mapper::locate(MapAnswer& answer) {
  const double travelled = path_.travelled();
  if (located_ || !locator_.is_due(travelled)) return;
  if (hypothesis_ && travelled < hypothesis_until_m_) {
    if (told_sigma_m_ > 0.0) suppose_change();
    return;
  }
  if (hypothesis_ && told_sigma_m_ > 0.0)
    answer.notes.emplace_back(
        "locate_at: the ground there is not the one driven over: not located");
  hypothesis_.reset();
  told_sigma_m_ = 0.0;
  const auto newest = Locator::last_searched(ground_.memory, end_of_before_);
  if (!newest) return;
  const MapPath::Place place = path_.place(newest->time, newest->distance_m);
  const PlanarPose body = body_at(place);
  hypothesis_ = locator_.find(ground_, end_of_before_, body, travelled);
  hypothesis_until_m_ = travelled + kConfirmWithin;
  if (!hypothesis_) return;
  change_.believe(hypothesis_->change);
  forget_searches();
}

// How the ground has changed is not told with a place. So the change that fits best near there is
// supposed, again and again, until the place is proved.
void Mapper::suppose_change() {
  const gpr::TraceMemory& memory = ground_.memory;
  if (!memory.can_undo() || path_.travelled() < next_change_m_) return;
  next_change_m_ = path_.travelled() + kSupposeEvery;
  const PlanarPose here = compose(hypothesis_->map_from_track, newest_node_.pose);
  const double gate = std::min(kGateSigmas * sigma_m(), kGateMax);
  const auto best = Locator::change_near(ground_, end_of_before_, {hypothesis_->map, here.p, gate});
  const gpr::TraceChange& now = change_.change();
  if (!best || (best->stretch == now.stretch && best->turn == now.turn)) return;
  change_.believe(*best);
  forget_searches();
}

// A place that was found is the best of a great many, and a drive over other ground tries many such
// places. So one revisit does not prove it: it needs another one whose patch has none of the
// ground of the first.
bool Mapper::is_proved() {
  if (told_sigma_m_ > 0.0) return true;
  const double travelled = path_.travelled();
  if (!hypothesis_->revisit_m) {
    hypothesis_->revisit_m = travelled;
    hypothesis_until_m_ = travelled + kAgainWithin;
  }
  return travelled - *hypothesis_->revisit_m >= config_.patch_length;
}

// The track is located: from now on `map` is the frame of the earlier ground.
void Mapper::join_map(const Hypothesis& at) {
  graph_->move(at.map_from_track);
  newest_node_.pose = compose(at.map_from_track, newest_node_.pose);
  Matrix5d turn = Matrix5d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(at.map_from_track.yaw).toRotationMatrix();
  newest_node_.covariance = turn * newest_node_.covariance * turn.transpose();
  map_ = at.map;
  moved_ = located_ = true;
  hypothesis_.reset();
  next_solve_ = 0;
}

// The memory's column at a node of this track; nothing if none is stored there.
std::optional<std::size_t> Mapper::column_at(std::size_t node) const {
  const auto column = ground_.memory.column_at(path_.time_of(node), end_of_before_);
  if (!column) return std::nullopt;
  const double apart = ground_.memory.column(*column).distance_m - path_.distance_of(node);
  return std::abs(apart) > kNodeSpacing ? std::nullopt : column;
}

Mapper::End Mapper::end_at(const MapPath::Place& place) const {
  return {place.node, place.at, graph_->nodes()[place.node].yaw, place.way};
}

std::optional<Mapper::End> Mapper::remembered_end(double column) const {
  const auto number = static_cast<std::size_t>(column);
  if (number < end_of_before_) {
    const auto then = ground_.at(column, 2 * kNodeSpacing);
    if (!then) return std::nullopt;
    return End{kInMap, then->pose, then->pose.yaw, {}};
  }
  const gpr::MemoryColumn then = ground_.memory.column(number);
  const double beyond = (column - static_cast<double>(number)) * ground_.memory.spacing();
  return end_at(path_.place(then.time, then.distance_m + then.direction * beyond));
}

// Returns false if both ends lie at the same node, or if the headings contradict the direction.
bool Mapper::add_edge(const End& memory, const End& query, RevisitEdge edge) {
  const bool turned = std::cos(query.yaw - memory.yaw) < 0.0;
  if (memory.node == query.node || turned != edge.mirrored) return false;
  edge.memory = memory.node;
  edge.query = query.node;
  edge.memory_at = compose(memory.body, antenna_);
  edge.query_at = compose(query.body, antenna_);
  edge.memory_way = memory.way;
  edge.query_way = query.way;
  graph_->add_revisit(edge);
  return true;
}

void Mapper::tie(const gpr::PlaceFound& found, const gpr::MemoryColumn& query, double moved_m,
                 MapAnswer& answer) {
  const gpr::MemoryColumn then = ground_.memory.column(static_cast<std::size_t>(found.column));
  const auto memory_end = remembered_end(found.column);
  if (!memory_end) return;
  const bool from_before = memory_end->node == kInMap;
  const MapPath::Place now = path_.place(query.time, query.distance_m);
  End query_end = end_at(now);
  if (from_before && !located_) query_end.yaw += hypothesis_->map_from_track.yaw;

  if (from_before && !located_ && !is_proved()) return;
  RevisitEdge edge = edge_of(found.match, moved_m, config_);
  // The memory has the direction of driving, the edge the heading. They differ when driving
  // backwards.
  edge.mirrored = found.match.mirrored == (then.direction == query.direction);
  if (!add_edge(*memory_end, query_end, edge)) return;
  if (from_before && !located_) join_map(*hypothesis_);
  // A track that is not located yet keeps all its ground, since the search in earlier ground needs
  // it whole.
  if (located_ || end_of_before_ == 0 || path_.travelled() > kLocatedWithin) {
    const double half = 0.5 * config_.patch_length;
    ground_.memory.mark_known(query.distance_m - half, query.distance_m + half);
  }

  Displacement told;
  told.from = from_before ? 0 : then.time;  // 0: the earlier pass belongs to another track
  told.to = query.time;
  told.source = "revisit";
  told.kind = DisplacementKind::kRevisit;
  told.valid = true;
  told.sigma_m = edge.sigma_m;
  told.lateral_sigma_m = edge.lateral_sigma_m;
  told.mirrored = found.match.mirrored;
  told.scale = found.match.scale;
  told.score = found.match.score;
  answer.revisits.push_back(std::move(told));
}

void Mapper::take_external(MapAnswer& answer) {
  while (!external_.empty() && external_.front().to <= path_.newest().time) {
    const Displacement told = external_.front();
    external_.pop_front();
    const MapPath::Place memory = path_.place(told.from), query = path_.place(told.to);
    RevisitEdge edge;
    edge.offset_m = told.distance_m;
    edge.sigma_m = std::max(kLeastRevisitSigma, told.sigma_m);
    edge.lateral_m = told.lateral_m;
    edge.lateral_sigma_m = told.lateral_sigma_m > 0 ? told.lateral_sigma_m : config_.lateral_sigma;
    edge.mirrored = told.mirrored == (memory.direction == query.direction);
    if (told.from < path_.time_of(0)) {
      answer.notes.push_back("a revisit of another process begins before the track: not used");
    } else if (path_.is_forgotten(told.from)) {
      answer.notes.push_back(
          "a revisit of another process begins on a pass that the map has merged with an "
          "earlier one: not used");
    } else if (!add_edge(end_at(memory), end_at(query), edge)) {
      answer.notes.push_back("a revisit of another process contradicts the headings: not used");
    }
  }
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

std::string Mapper::ground_bytes() const { return to_bytes(ground_, places()); }

GroundMap Mapper::take_ground() {
  ground_.memory.end_run();
  note_origin();
  ground_.places = places();
  return std::move(ground_);
}

void Mapper::solve(double scale, double scale_sigma, MapAnswer& answer) {
  const double every =
      std::max(kSolveEvery, kSolveEveryNode * static_cast<double>(graph_->nodes().size()));
  next_solve_ = path_.newest().time + from_seconds(every);
  solve_anyway_ = path_.newest().time + from_seconds(std::max(kSolveAnyway, every));
  try {
    const PoseGraphSolution solution = graph_->solve(scale, scale_sigma);
    newest_node_ = solution.newest;
    trusted_ = solution.trusted;
  } catch (const std::runtime_error& error) {
    answer.notes.emplace_back(error.what());
  }
}

}  // namespace gprodom
