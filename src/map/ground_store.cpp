#include "map/ground_store.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "gprodom/version.h"
#include "map/crowded_ground.h"

namespace gprodom {
namespace {

constexpr double kLocatedWithin = 200.0;  // m driven, then known ground is no longer stored twice

}  // namespace

gpr::TraceMemoryOptions memory_options(const Config& config) {
  gpr::TraceMemoryOptions options;
  options.filter.wave_speed = config.gpr.wave_speed;
  return options;
}

GroundStore::GroundStore(const Config& config, std::optional<GroundMap> before)
    : antennas_(config.gpr.antennas),
      lever_arm_(config.gpr.lever_arm),
      patch_length_m_(config.graph.patch_length),
      longest_arm_m_(lever_arm_.head<2>().norm()),
      ground_(before ? without_crowded(std::move(*before), config.graph.lateral_sigma)
                     : GroundMap(memory_options(config))),
      origin_{lever_arm_, kVersion, config.state.robot, {}, 0},
      end_of_before_(ground_.memory.kept().end),
      first_session_(ground_.memory.sessions().size()),
      map_(ground_.unused_map()),
      saved_end_(end_of_before_) {
  const auto reach = [this](const Eigen::Vector3d& antenna) {
    longest_arm_m_ = std::max(longest_arm_m_, antenna.head<2>().norm());
  };
  for (const auto& [id, antenna] : antennas_) reach(antenna);
  for (const SessionOrigin& origin : ground_.origins) reach(origin.antenna);
  ground_.memory.begin_session();
  if (ground_.identity != 0) saved_ = SavedColumns{ground_.identity, 0, end_of_before_};
}

std::optional<PlanarPose> GroundStore::antenna(int id) const {
  const auto found = antennas_.find(id);
  if (found == antennas_.end()) return std::nullopt;
  return PlanarPose{found->second.head<2>(), 0.0};
}

void GroundStore::locate_in(int map, bool begins) {
  map_ = map;
  located_ = !begins || ground_.holds(map);
}

void GroundStore::move_places(int map, const PlanarPose& by) {
  for (KnownPlace& place : ground_.places) {
    if (place.map != map) continue;
    place.pose = compose(by, place.pose);
    saved_.reset();  // a file of what is new has new places alone
  }
}

bool GroundStore::remember(const GprTrace& trace, const MapPath& path,
                           std::vector<std::string>& notes) {
  const TraceFormat format = format_of(trace);
  if (ground_.format.samples != 0 && !same_format(ground_.format, format)) {
    notes.emplace_back("trace of another length or interval than the ground's: not stored");
    return false;
  }
  ground_.format = format;
  const bool elsewhere = origin_.antenna_id != trace.antenna_id && follow_antenna(trace.antenna_id);
  ground_.memory.add(trace.time, trace.samples, trace.sample_interval_s,
                     path.distance_at(trace.time));
  last_trace_ = trace.time;
  note_origin();
  return elsewhere;
}

bool GroundStore::follow_antenna(int antenna_id) {
  const auto place = antennas_.find(antenna_id);
  const Eigen::Vector3d& lever_arm = place == antennas_.end() ? lever_arm_ : place->second;
  const bool is_elsewhere = lever_arm != origin_.antenna;
  if (is_elsewhere) {
    ground_.memory.end_run();
    note_origin();
  }
  origin_.antenna_id = antenna_id;
  if (!is_elsewhere) return false;
  origin_.antenna = lever_arm;
  ground_.memory.begin_session();
  for (std::size_t i = first_session_; i < ground_.origins.size(); ++i)
    if (ground_.origins[i].antenna == lever_arm) ground_.memory.resume_session(i);
  return true;
}

void GroundStore::note_origin() {
  ground_.origins.resize(ground_.memory.sessions().size(), origin_);
  const std::size_t end = ground_.memory.kept().end;
  if (end <= end_of_before_ || end == noted_end_) return;
  ground_.extended(end_of_before_, last_trace_, noted_end_ == 0);
  noted_end_ = end;
  for (std::size_t i = first_session_; i < ground_.origins.size(); ++i)
    ground_.origins[i].errors = origin_.errors;
}

void GroundStore::mark_known(const gpr::MemoryColumn& query, double travelled_m) {
  if (!located_ && end_of_before_ > 0 && travelled_m <= kLocatedWithin) return;
  const double half = 0.5 * patch_length_m_;
  ground_.memory.mark_known(query.distance_m - half, query.distance_m + half);
}

std::optional<std::size_t> GroundStore::column_at(const MapPath& path, std::size_t node) const {
  const auto column = ground_.memory.column_at(path.time_of(node), end_of_before_);
  if (!column) return std::nullopt;
  const double apart = ground_.memory.column(*column).distance_m - path.distance_of(node);
  return std::abs(apart) > kNodeSpacing ? std::nullopt : column;
}

PlanarPose GroundStore::antenna_at(const MapPath& path, std::size_t node) const {
  const auto column = column_at(path, node);
  return column ? ground_.antenna_at(*column, antenna()) : antenna();
}

std::optional<RevisitEnd> GroundStore::end_at(double column, const TrackGraph& track) const {
  const auto number = static_cast<std::size_t>(column);
  const PlanarPose antenna = ground_.antenna_at(number, this->antenna());
  if (number < end_of_before_) {
    const auto then = ground_.at(column, 2 * kNodeSpacing);
    if (!then) return std::nullopt;
    return RevisitEnd{kInMap, then->pose, then->pose.yaw, {}, antenna};
  }
  const gpr::MemoryColumn then = ground_.memory.column(number);
  const double beyond = (column - static_cast<double>(number)) * ground_.memory.spacing();
  return track.end_at(track.path().place(then.time, then.distance_m + then.direction * beyond),
                      antenna);
}

std::vector<KnownPlace> GroundStore::places(const TrackGraph& track) const {
  // Only places whose ground is still stored.
  const std::size_t first = ground_.memory.kept().first;
  std::vector<KnownPlace> all;
  std::copy_if(ground_.places.begin(), ground_.places.end(), std::back_inserter(all),
               [first](const KnownPlace& place) { return place.column >= first; });
  const auto off = [this](const KnownPlace& place) {
    return std::abs(place.distance_m - ground_.memory.column(place.column).distance_m);
  };
  const MapPath& path = track.path();
  for (std::size_t node = 0; track.begun() && node < path.nodes(); ++node) {
    const auto column = column_at(path, node);
    if (!column) continue;
    const KnownPlace place{*column, path.distance_of(node), track.graph().nodes()[node], map_};
    // Where no ground is stored, several nodes have the run's last column: the nearest counts.
    if (all.empty() || all.back().column != *column) {
      all.push_back(place);
    } else if (off(place) < off(all.back())) {
      all.back() = place;
    }
  }
  return all;
}

SavedGround GroundStore::saved(const TrackGraph& track, bool main) {
  SavedGround saved{to_bytes(ground_, places(track)), ground_.descent, !ground_.memory.filter(), 0};
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

SavedGround GroundStore::newest(const TrackGraph& track) {
  const gpr::MemoryRange kept = ground_.memory.kept();
  if (kept.end == saved_end_ || ground_.memory.sessions().empty()) return {};
  if (!saved_ || kept.first > saved_->end) return saved(track, true);
  saved_end_ = kept.end;
  return {newest_to_bytes(ground_, places(track), end_of_before_, *saved_), ground_.descent, false,
          saved_->identity};
}

GroundMap GroundStore::take(const TrackGraph& track) {
  ground_.memory.end_run();
  note_origin();
  ground_.places = places(track);
  return std::move(ground_);
}

GroundMap GroundStore::take_earlier(const TrackGraph& track) {
  GroundMap all = take(track);
  const std::vector<gpr::MemoryRange> runs = all.runs();
  if (runs.empty() || runs.back().end <= end_of_before_) return all;
  std::vector<gpr::MemoryRange> earlier;
  for (const gpr::MemoryRange& run : runs)
    if (run.first < end_of_before_)
      earlier.push_back({run.first, std::min(run.end, end_of_before_)});
  return earlier.empty() ? GroundMap(all.memory.options()) : all.part(earlier);
}

}  // namespace gprodom
