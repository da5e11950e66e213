#include "map/pass_merger.h"

#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

constexpr double kCell = 2.0;     // m
constexpr double kNearTie = 2.0;  // m driven; a node so near to a revisit lies on tied ground
constexpr int kRelations = 8;     // nodes that stay for each pair of cells

// The cell of a place along the track; negative for a place that is fixed in map.
std::int64_t cell_along(double travelled_m) {
  return static_cast<std::int64_t>(std::floor(travelled_m / kCell));
}

std::int64_t cell_in_map(const Eigen::Vector2d& p) {
  const Eigen::Vector2d corner = (p / kCell).array().floor();
  constexpr std::int64_t kRow = std::int64_t{1} << 30U;
  return -(kRow / 2 * kRow) + static_cast<std::int64_t>(corner.x()) * kRow +
         static_cast<std::int64_t>(corner.y());
}

}  // namespace

// For each node, the cell on which it lies or to which it is tied, and whether a revisit ends
// there.
struct PassMerger::Tied {
  std::vector<std::optional<Cell>> cells;
  std::vector<bool> is_memory, is_near;

  Tied(const std::vector<Node>& nodes, const std::vector<RevisitEdge>& revisits,
       const std::vector<bool>& trusted)
      : cells(nodes.size()), is_memory(nodes.size()), is_near(nodes.size()) {
    std::vector<bool> is_tied(nodes.size());
    for (std::size_t i = 0; i < revisits.size(); ++i) {
      const RevisitEdge& edge = revisits[i];
      const bool in_map = edge.memory == kInMap;
      if (!in_map) is_memory[edge.memory] = true;
      if (i >= trusted.size() || !trusted[i]) continue;
      is_tied[edge.query] = true;
      if (!cells[edge.query]) {
        cells[edge.query] =
            in_map ? cell_in_map(edge.memory_at.p) : cell_along(nodes[edge.memory].travelled_m);
      }
    }
    std::optional<double> last;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].has_ground) cells[i] = cell_along(nodes[i].travelled_m);
      if (is_tied[i]) last = nodes[i].travelled_m;
      is_near[i] = last && nodes[i].travelled_m - *last <= kNearTie;
    }
    last.reset();
    for (std::size_t i = nodes.size(); i-- > 0;) {
      if (is_tied[i]) last = nodes[i].travelled_m;
      is_near[i] = is_near[i] || (last && *last - nodes[i].travelled_m <= kNearTie);
    }
  }
};

// A node is worth keeping if few nodes so far relate its cell to the one before or after. Then it
// is counted as one of them.
bool PassMerger::is_worth_keeping(Cell cell, std::optional<Cell> next) {
  std::vector<int*> counts;
  if (previous_) counts.push_back(&relations_[std::minmax(*previous_, cell)]);
  if (next && next != previous_) counts.push_back(&relations_[std::minmax(*next, cell)]);
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
  const Tied tied(nodes, revisits, trusted);
  const double behind = nodes.back().travelled_m - kInFull;
  std::size_t i = judged_;
  for (; i < nodes.size() && nodes[i].travelled_m < behind; ++i) {
    const std::optional<Cell> cell = tied.cells[i];
    const bool can_go = i > 0 && !nodes[i].has_ground && tied.is_near[i] && !tied.is_memory[i];
    if (can_go) {
      const auto next = std::find_if(tied.cells.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                     tied.cells.end(), [](const auto& c) { return c.has_value(); });
      stay[i] = cell && is_worth_keeping(*cell, next == tied.cells.end() ? std::nullopt : *next);
    }
    if (cell) previous_ = cell;
  }
  judged_ = static_cast<std::size_t>(
      std::count(stay.begin(), stay.begin() + static_cast<std::ptrdiff_t>(i), true));
  return stay;
}

}  // namespace gprodom
