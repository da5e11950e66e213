#include "map/pass_merger.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gprodom {
namespace {

constexpr double kCell = 2.0;     // m
constexpr double kNearTie = 2.0;  // m driven; a node so near to a revisit lies on tied ground
// m driven from one revisit to the next, if the ground between them was not recognised. The yaw of
// a joined step of this length is known to far less than 0.1 rad, so that it stays linear.
constexpr double kBetweenTies = 20.0;
constexpr int kRelations = 8;  // nodes that stay for each pair of cells
// m driven from a cell to one that it is related to. In a longer gap the ground is stored, or it is
// ground of which enough is stored: the map knows the way without this pass. (Of new ground that is
// shorter, nothing is stored: TraceMemoryOptions::least_m.)
constexpr double kOneWay = 3.5;

std::pair<int, int> cell_at(const Eigen::Vector2d& p) {
  const Eigen::Vector2d corner = (p / kCell).array().floor();
  return {static_cast<int>(corner.x()), static_cast<int>(corner.y())};
}

}  // namespace

// For each node, the cell if it lies on known ground, and whether a revisit ends there or near by.
// Cells are places in map: several stored passes over the same place are one.
struct PassMerger::Tied {
  std::vector<std::optional<Cell>> cells;
  std::vector<bool> is_tied, is_memory, is_near;

  // last: m driven up to the last tie before the nodes that are judged now.
  Tied(const std::vector<Node>& nodes, const std::vector<RevisitEdge>& revisits,
       const std::vector<bool>& trusted, double last)
      : cells(nodes.size()), is_tied(nodes.size()), is_memory(nodes.size()), is_near(nodes.size()) {
    for (std::size_t i = 0; i < revisits.size(); ++i) {
      const RevisitEdge& edge = revisits[i];
      if (edge.memory != kInMap) is_memory[edge.memory] = true;
      if (i < trusted.size() && trusted[i]) is_tied[edge.query] = true;
    }
    constexpr double kNone = std::numeric_limits<double>::infinity();
    std::vector<double> since(nodes.size());  // m driven since the last tie
    double next = kNone;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (is_tied[i]) last = std::max(last, nodes[i].travelled_m);
      since[i] = nodes[i].travelled_m - last;
      if (nodes[i].has_ground || is_tied[i]) cells[i] = cell_at(nodes[i].in_map);
    }
    for (std::size_t i = nodes.size(); i-- > 0;) {
      if (is_tied[i]) next = nodes[i].travelled_m;
      const double until = next - nodes[i].travelled_m;
      is_near[i] = std::min(since[i], until) <= kNearTie || since[i] + until <= kBetweenTies;
    }
  }
};

// A node is worth keeping if few nodes so far relate its cell to another one before or after. Then
// it is counted as one of them. What lies in the same cell is known well enough by one node.
bool PassMerger::is_worth_keeping(const Visit& visit, const std::optional<Visit>& next) {
  const auto relates = [&](const std::optional<Visit>& other) {
    return other && other->cell != visit.cell &&
           std::abs(other->travelled_m - visit.travelled_m) <= kOneWay;
  };
  std::vector<int*> counts;
  if (relates(previous_)) counts.push_back(&relations_[std::minmax(previous_->cell, visit.cell)]);
  if (relates(next) && !(previous_ && next->cell == previous_->cell))
    counts.push_back(&relations_[std::minmax(next->cell, visit.cell)]);
  const bool worth = std::any_of(counts.begin(), counts.end(),
                                 [](const int* count) { return *count < kRelations; });
  if (!worth) return false;
  for (int* count : counts) ++*count;
  return true;
}

std::vector<bool> PassMerger::judge(const std::vector<Node>& nodes,
                                    const std::vector<RevisitEdge>& revisits,
                                    const std::vector<bool>& trusted) {
  std::vector<bool> stay(nodes.size(), true);
  const Tied tied(nodes, revisits, trusted, tied_at_m_);
  const double behind = nodes.back().travelled_m - kInFull;
  std::size_t i = judged_;
  for (; i < nodes.size() && nodes[i].travelled_m < behind; ++i) {
    const std::optional<Cell> cell = tied.cells[i];
    const bool can_go = i > 0 && !nodes[i].has_ground && tied.is_near[i] && !tied.is_memory[i];
    if (can_go) {
      std::optional<Visit> next;
      for (std::size_t k = i + 1; k < nodes.size() && !next; ++k)
        if (tied.cells[k]) next = Visit{*tied.cells[k], nodes[k].travelled_m};
      stay[i] = cell && is_worth_keeping({*cell, nodes[i].travelled_m}, next);
    }
    if (cell) previous_ = Visit{*cell, nodes[i].travelled_m};
    if (tied.is_tied[i]) tied_at_m_ = nodes[i].travelled_m;
  }
  judged_ = static_cast<std::size_t>(
      std::count(stay.begin(), stay.begin() + static_cast<std::ptrdiff_t>(i), true));
  return stay;
}

}  // namespace gprodom
