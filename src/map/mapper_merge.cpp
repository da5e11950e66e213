// Mapper: removes nodes of passes over known ground from the graph.
#include <algorithm>
#include <optional>
#include <utility>

#include "map/mapper.h"

namespace gprodom {
namespace {

constexpr double kMergeEvery = 5.0;  // m driven

}  // namespace

std::vector<Revisit> Mapper::revisits() const {
  std::vector<Revisit> all = merged_;
  for (std::size_t i = 0; i < trusted_.size(); ++i) {
    if (trusted_[i] && graph_->revisits()[i].memory != kInMap) all.push_back(told(i));
  }
  return all;
}

std::vector<TrackPiece> Mapper::track() const {
  std::vector<TrackPiece> pieces;
  for (std::size_t node = 0; graph_ && node < path_.nodes(); ++node) {
    const bool last = node + 1 == path_.nodes();
    std::optional<double> slip;
    if (graph_->slip_sigma(node) > 0) slip = last ? newest_node_.slip : graph_->slip(node);
    pieces.push_back({path_.time_of(node), path_.pose_of(node), graph_->nodes()[node], slip});
  }
  return pieces;
}

Revisit Mapper::told(std::size_t revisit) const {
  RevisitEdge edge = graph_->revisits()[revisit];
  const auto as_driven = [&](std::size_t node, const PlanarPose& at, const WheelWay& way) {
    return between(graph_->nodes()[node], graph_->place(node, at, way));
  };
  edge.memory_at = as_driven(edge.memory, edge.memory_at, edge.memory_way);
  edge.query_at = as_driven(edge.query, edge.query_at, edge.query_way);
  edge.memory_way = edge.query_way = {};
  return {path_.time_of(edge.memory), path_.time_of(edge.query), edge};
}

void Mapper::merge() {
  if (path_.travelled() < next_merge_m_) return;
  next_merge_m_ = path_.travelled() + kMergeEvery;
  std::vector<PassMerger::Node> nodes(path_.nodes());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = {path_.travelled_at(i), column_at(i).has_value(), graph_->nodes()[i].p};
  }
  for (const FixEdge& fix : graph_->fixes()) nodes[fix.node].has_fix = true;
  const auto [stay, cut] = merger_.judge(nodes, graph_->revisits(), trusted_);
  if (std::find(stay.begin(), stay.end(), false) == stay.end()) return;

  std::vector<bool> trusted;  // revisits newer than the last solution are at nodes that stay anyway
  for (std::size_t i = 0; i < trusted_.size(); ++i) {
    const RevisitEdge& edge = graph_->revisits()[i];
    const bool in_map = edge.memory == kInMap;
    if (stay[edge.query] && (in_map || stay[edge.memory])) {
      trusted.push_back(trusted_[i]);
    } else {
      ++(trusted_[i] ? merged_trusted_ : merged_refused_);
      if (record_ && trusted_[i] && !in_map) merged_.push_back(told(i));
    }
  }
  trusted_ = std::move(trusted);
  graph_->keep_only(stay, cut);
  path_.keep_only(stay);
  place_fixes();
}

}  // namespace gprodom
