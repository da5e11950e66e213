#include "pipeline/mapper.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace gprodom {
namespace {

constexpr std::size_t kMaxWindows = 2;    // passes over a place that are looked at
constexpr double kHeadingGate = 0.5;      // rad between the tracks then and now
constexpr double kLeastSigma = 0.005;     // m, of a revisit
constexpr double kSolveEvery = 1.0;       // s of data time, and
constexpr double kSolveEveryNode = 1e-3;  // s of data time a node, so that the work stays bounded
constexpr int kBefore = 58;  // columns before the query in which the memory is looked for in turn

gpr::TraceMemoryOptions memory_options(const Config& config) {
  gpr::TraceMemoryOptions options;
  options.max_length_m = config.graph.memory_length;
  options.filter.wave_speed = config.gpr.wave_speed;
  return options;
}

double wrap(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace

Mapper::Mapper(const Config& config)
    : config_(config.graph),
      antenna_{config.gpr.lever_arm.head<2>(), 0.0},
      path_(config.graph.node_spacing),
      memory_(memory_options(config)) {}

MapAnswer Mapper::run(const MapInput& input) {
  MapAnswer answer;
  follow(input.states);
  if (!graph_) return answer;
  external_.insert(external_.end(), input.revisits.begin(), input.revisits.end());
  take_external();
  for (const GprTrace& trace : input.traces) {
    remember(trace, answer);
    look(answer);
  }
  if (!graph_->revisits().empty() && path_.newest().time >= next_solve_) {
    solve(input.scale, input.scale_sigma);
  }
  const auto trusted = static_cast<int>(std::count(trusted_.begin(), trusted_.end(), true));
  if (trusted > 0) {
    answer.pose = MapPose{extend(newest_node_, path_.since_last_node()), path_.newest(), trusted,
                          static_cast<int>(trusted_.size()) - trusted};
  }
  return answer;
}

void Mapper::follow(const std::vector<PathState>& states) {
  for (const PathState& state : states) {
    const std::optional<PlanarStep> step = path_.add(state);
    if (!graph_) {
      PoseGraphOptions options;
      graph_.emplace(state.pose, options);
      newest_node_.pose = state.pose;
    }
    if (!step) continue;
    graph_->add_node(*step);
    newest_node_ = extend(newest_node_, *step);
  }
}

void Mapper::remember(const GprTrace& trace, MapAnswer& answer) {
  const bool changed = samples_ != 0 && (trace.samples.size() != samples_ ||
                                         std::abs(trace.sample_interval_s - sample_interval_s_) >
                                             1e-6 * sample_interval_s_);
  if (changed) {
    memory_.clear();
    search_.reset();
    last_query_.reset();
    answer.notes.push_back("traces of another length or interval: the ground seen is forgotten");
  }
  samples_ = trace.samples.size();
  sample_interval_s_ = trace.sample_interval_s;
  memory_.add(trace.time, trace.samples, trace.sample_interval_s, path_.distance_at(trace.time));
}

// Asks the memory where the newest ground was seen before, every query_spacing.
void Mapper::look(MapAnswer& answer) {
  if (!memory_.filter()) return;
  if (!search_) {
    gpr::RevisitSearchOptions options;
    options.patch_m = config_.patch_length;
    options.certainty = config_.certainty;
    search_.emplace(*memory_.filter(), memory_.spacing(), options);
  }
  const auto place = memory_.newest_place(search_->patch_columns());
  if (!place) return;
  double moved = config_.patch_length;
  if (last_query_ && last_query_->direction == place->direction) {
    moved = std::abs(place->distance_m - last_query_->distance_m);
    if (moved < config_.query_spacing) return;
  } else {
    search_->forget();
  }
  last_query_ = place;
  const std::vector<gpr::SearchWindow> near = windows(*place);
  if (near.empty()) {
    search_->forget();
    return;
  }
  const auto newest = memory_.newest(search_->patch_columns(), kBefore);
  for (const gpr::PlaceFound& found : search_->look(newest->features, moved, near)) {
    tie(found, *place, moved, answer);
  }
}

// Stretches of remembered ground where, by the poses, the query may lie: those nearest beside the
// track come first.
std::vector<gpr::SearchWindow> Mapper::windows(const gpr::MemoryColumn& query) const {
  const MapPath::Place at = path_.place(query.time, query.distance_m);
  const PlanarPose here = compose(graph_->nodes()[at.node], antenna(at.at));
  const double sigma = std::sqrt(newest_node_.covariance.topLeftCorner<2, 2>().trace());
  const double gate = std::clamp(config_.gate_sigmas * sigma, config_.gate_min, config_.gate_max);
  const double aside =
      config_.lateral_gate + std::min(config_.gate_sigmas * sigma, config_.gate_max);
  // Ground that the query itself lies on, or that was driven over just before.
  const double newest = path_.travelled_at(at.node) - config_.patch_length - gate;

  const double farthest = gate + config_.node_spacing + aside + antenna_.p.norm();

  struct Candidate {
    std::size_t node;
    double along, lateral;
  };
  std::vector<Candidate> candidates;
  bool on_track = false;  // the node before was a candidate of the same pass
  for (std::size_t node = 0; node < at.node && path_.travelled_at(node) < newest; ++node) {
    if ((graph_->nodes()[node].p - here.p).squaredNorm() > farthest * farthest) {
      on_track = false;
      continue;
    }
    const PlanarPose then = compose(graph_->nodes()[node], antenna_);
    const PlanarPose relative = between(then, here);
    const double turned = wrap(relative.yaw);
    const bool parallel =
        std::abs(turned) < kHeadingGate || std::abs(wrap(turned + M_PI)) < kHeadingGate;
    const bool near = parallel && std::abs(relative.p.y()) < aside &&
                      std::abs(relative.p.x()) < gate + config_.node_spacing;
    if (near) {
      const Candidate candidate{node, relative.p.x(), relative.p.y()};
      if (!on_track) candidates.push_back(candidate);
      if (std::abs(candidate.along) < std::abs(candidates.back().along)) {
        candidates.back() = candidate;
      }
    }
    on_track = near;
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return std::abs(a.lateral) < std::abs(b.lateral);
  });
  std::vector<gpr::SearchWindow> windows;
  for (const Candidate& candidate : candidates) {
    const auto column = memory_.column_at(path_.time_of(candidate.node));
    if (!column || windows.size() == kMaxWindows) continue;
    const double apart = memory_.column(*column).distance_m - path_.distance_of(candidate.node);
    if (std::abs(apart) > config_.node_spacing) continue;  // nothing is kept of that place
    windows.push_back(window_at(candidate.node, *column, candidate.along, gate));
  }
  return windows;
}

gpr::SearchWindow Mapper::window_at(std::size_t node, std::size_t column, double along,
                                    double gate) const {
  const gpr::MemoryColumn then = memory_.column(column);
  const gpr::MemoryRange run = memory_.run_of(column);
  const double ahead = path_.distance_of(node) + along - then.distance_m;
  gpr::SearchWindow window;
  window.run = run.first;
  window.expected = static_cast<double>(column) + then.direction * ahead / memory_.spacing();
  window.bound_m = gate;
  const double reach = (gate + 1.0 + 0.6 * config_.patch_length) / memory_.spacing() + 4.0;
  const auto clamped = [&](double number) {
    return static_cast<std::size_t>(
        std::clamp(number, static_cast<double>(run.first), static_cast<double>(run.end)));
  };
  window.first = clamped(std::floor(window.expected - reach));
  window.features = memory_.patch({window.first, clamped(std::ceil(window.expected + reach))});
  return window;
}

// Whether, by the headings, the robot faced the other way (mirrored) or the same.
bool Mapper::faces(const MapPath::Place& then, const MapPath::Place& now, bool mirrored) const {
  const double turned = graph_->nodes()[now.node].yaw - graph_->nodes()[then.node].yaw;
  return mirrored == (std::cos(turned) < 0.0);
}

PlanarPose Mapper::antenna(const PlanarPose& at) const { return compose(at, antenna_); }

void Mapper::tie(const gpr::PlaceFound& found, const gpr::MemoryColumn& query, double moved_m,
                 MapAnswer& answer) {
  const auto number = static_cast<std::size_t>(found.column);
  gpr::MemoryColumn then = memory_.column(number);
  then.distance_m +=
      then.direction * (found.column - static_cast<double>(number)) * memory_.spacing();
  const MapPath::Place memory_place = path_.place(then.time, then.distance_m);
  const MapPath::Place query_place = path_.place(query.time, query.distance_m);
  if (memory_place.node == query_place.node) return;
  // The ground knows the direction driven, the edge the one faced: they differ driving backwards.
  const bool mirrored = found.match.mirrored == (then.direction == query.direction);
  if (!faces(memory_place, query_place, mirrored)) return;

  // Patches that overlap have their errors in common: together they count as often as they fit
  // into the ground.
  const double fresh = std::min(1.0, moved_m / config_.patch_length);
  RevisitEdge edge{memory_place.node, query_place.node};
  edge.memory_at = antenna(memory_place.at);
  edge.query_at = antenna(query_place.at);
  edge.sigma_m =
      std::max(kLeastSigma, config_.sigma_factor * found.match.sigma_m) / std::sqrt(fresh);
  edge.lateral_sigma_m = config_.lateral_sigma / std::sqrt(fresh);
  edge.mirrored = mirrored;
  graph_->add_revisit(edge);

  Displacement told;
  told.from = then.time;
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

void Mapper::take_external() {
  while (!external_.empty() && external_.front().to <= path_.newest().time) {
    const Displacement& told = external_.front();
    const MapPath::Place memory_place = path_.place(told.from);
    const MapPath::Place query_place = path_.place(told.to);
    const bool mirrored = told.mirrored == (memory_place.direction == query_place.direction);
    if (told.from >= path_.time_of(0) && memory_place.node != query_place.node &&
        faces(memory_place, query_place, mirrored)) {
      RevisitEdge edge{memory_place.node, query_place.node};
      edge.memory_at = antenna(memory_place.at);
      edge.query_at = antenna(query_place.at);
      edge.offset_m = told.distance_m;
      edge.sigma_m = std::max(kLeastSigma, told.sigma_m);
      edge.lateral_m = told.lateral_m;
      edge.lateral_sigma_m =
          told.lateral_sigma_m > 0 ? told.lateral_sigma_m : config_.lateral_sigma;
      edge.mirrored = mirrored;
      graph_->add_revisit(edge);
    }
    external_.pop_front();
  }
}

std::vector<Revisit> Mapper::revisits() const {
  std::vector<Revisit> all;
  for (std::size_t i = 0; i < trusted_.size(); ++i) {
    const RevisitEdge& edge = graph_->revisits()[i];
    if (trusted_[i]) all.push_back({path_.time_of(edge.memory), path_.time_of(edge.query), edge});
  }
  return all;
}

void Mapper::solve(double scale, double scale_sigma) {
  const PoseGraphSolution solution = graph_->solve(scale, scale_sigma);
  newest_node_ = solution.newest;
  trusted_ = solution.trusted;
  next_solve_ = path_.newest().time +
                from_seconds(std::max(
                    kSolveEvery, kSolveEveryNode * static_cast<double>(graph_->nodes().size())));
}

}  // namespace gprodom
