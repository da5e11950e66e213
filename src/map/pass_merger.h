// What of the pose graph stays of a pass over ground that the map knows already. Nothing of a pass
// over new ground is ever merged: it is the map. docs/revisit.md, "Ground driven again and again".
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "estimation/graph/pose_graph.h"

namespace gprodom {

class PassMerger {
 public:
  struct Node {
    double travelled_m = 0.0;  // up to it, unsigned
    bool has_ground = false;   // the memory keeps the ground there
  };

  // All nodes of the graph, and its revisits: those that it trusts count as ties. Which nodes stay:
  // all but some of those left behind by `kInFull` since the last call. The others were judged
  // then, and stay.
  std::vector<bool> judge(const std::vector<Node>& nodes, const std::vector<RevisitEdge>& revisits,
                          const std::vector<bool>& trusted);

  static constexpr double kInFull = 50.0;  // m driven, of which the graph keeps everything

 private:
  using Cell = std::int64_t;  // of ground, kCell long

  struct Tied;
  bool is_worth(Cell cell, std::optional<Cell> next);

  std::size_t judged_ = 0;        // nodes, as they are numbered after the last call
  std::optional<Cell> previous_;  // the cell that the last node judged lies on or is tied to
  std::map<std::pair<Cell, Cell>, int> relations_;
};

}  // namespace gprodom
