// Decides which nodes of the pose graph stay after a pass over ground that the map already knows.
// Nodes over new ground always stay: they are the map. docs/revisit.md, "Ground driven again and
// again".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "estimation/graph/pose_graph.h"

namespace gprodom {

class PassMerger {
 public:
  struct Node {
    double travelled_m = 0.0;                          // distance driven up to the node, unsigned
    bool has_ground = false;                           // the memory stores the ground there
    Eigen::Vector2d in_map = Eigen::Vector2d::Zero();  // m
  };

  // Takes all nodes of the graph and its revisits, of which the trusted ones count. Returns which
  // nodes stay. Only nodes that have come to lie further back than `kInFull` since the last call
  // are judged; all others stay.
  std::vector<bool> judge(const std::vector<Node>& nodes, const std::vector<RevisitEdge>& revisits,
                          const std::vector<bool>& trusted);

  static constexpr double kInFull = 50.0;  // m driven; newer nodes all stay

 private:
  using Cell = std::pair<int, int>;  // of map, kCell long and wide

  struct Tied;
  struct Visit {
    Cell cell;
    double travelled_m;
  };
  bool is_worth_keeping(const Visit& visit, const std::optional<Visit>& next);

  std::size_t judged_ = 0;         // number of nodes judged so far that stay
  std::optional<Visit> previous_;  // of the last node judged that lies on or is tied to a cell
  // m driven up to the last node judged that was tied; it may not have stayed
  double tied_at_m_ = -std::numeric_limits<double>::infinity();
  std::map<std::pair<Cell, Cell>, int> relations_;
};

}  // namespace gprodom
