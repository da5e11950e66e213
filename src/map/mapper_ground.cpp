// Mapper: the ground that it stores, and gives to a map file.
#include <algorithm>
#include <cmath>
#include <utility>

#include "map/ground_map_file.h"
#include "map/mapper.h"

namespace gprodom {

void Mapper::remember(const GprTrace& trace, MapAnswer& answer) {
  const TraceFormat format = format_of(trace);
  if (ground_.format.samples != 0 && !same_format(ground_.format, format)) {
    answer.notes.push_back("trace of another length or interval than the ground's: not stored");
    return;
  }
  ground_.format = format;
  if (origin_.antenna_id != trace.antenna_id) follow_antenna(trace.antenna_id);
  ground_.memory.add(trace.time, trace.samples, trace.sample_interval_s,
                     path_.distance_at(trace.time));
  last_trace_ = trace.time;
  note_origin();
}

// Ground that another antenna sees is a session of its own, of which the place of the antenna is
// known.
void Mapper::follow_antenna(int antenna_id) {
  const auto place = antennas_.find(antenna_id);
  const Eigen::Vector3d& lever_arm = place == antennas_.end() ? lever_arm_ : place->second;
  const bool is_elsewhere = lever_arm != origin_.antenna;
  if (is_elsewhere) {
    ground_.memory.end_run();
    note_origin();
  }
  origin_.antenna_id = antenna_id;
  if (!is_elsewhere) return;
  origin_.antenna = lever_arm;
  seeker_.antenna = {lever_arm.head<2>(), 0.0};
  seeker_.last_query.reset();
  forget_searches();
  ground_.memory.begin_session();
  for (std::size_t i = first_session_; i < ground_.origins.size(); ++i)
    if (ground_.origins[i].antenna == lever_arm) ground_.memory.resume_session(i);
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
  for (std::size_t i = first_session_; i < ground_.origins.size(); ++i)
    ground_.origins[i].errors = origin_.errors;
}

// The memory's column at a node of this track; nothing if none is stored there.
std::optional<std::size_t> Mapper::column_at(std::size_t node) const {
  const auto column = ground_.memory.column_at(path_.time_of(node), end_of_before_);
  if (!column) return std::nullopt;
  const double apart = ground_.memory.column(*column).distance_m - path_.distance_of(node);
  return std::abs(apart) > kNodeSpacing ? std::nullopt : column;
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

}  // namespace gprodom
