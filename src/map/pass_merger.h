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
    bool has_fix = false;
  };

  // For each node: whether it stays, and whether the step into it is cut.
  struct Judgement {
    std::vector<bool> stay, cut;
  };
  // Takes all nodes of the graph and its revisits, of which the trusted ones count. Only nodes that
  // have come to lie further back than `kInFull` since the last call are judged; all others stay.
  // A step is cut only between nodes that trusted revisits tie to the map.
  Judgement judge(const std::vector<Node>& nodes, const std::vector<RevisitEdge>& revisits,
                  const std::vector<bool>& trusted);

  static constexpr double kInFull = 50.0;  // m driven; newer nodes all stay

 private:
  // A place of the map, to which what lies near by belongs. It moves with its node.
  struct Place {
    std::size_t node = 0;                         // kInMap: it is held
    Eigen::Vector2d p = Eigen::Vector2d::Zero();  // m
  };
  struct Visit {  // of a cell, by a node that lies on or is tied to it
    std::size_t node, cell;
  };
  class Ties;
  class Cells;
  struct Piece;
  std::optional<Piece> next_piece(const std::vector<Node>& nodes, const Ties& ties);
  bool is_known_way(const std::vector<Node>& nodes, const Ties& ties, const Cells& cells,
                    const Visit& a, const Visit& b) const;
  bool are_known(std::size_t a, std::size_t b) const;
  void cut(const Piece& piece, const Ties& ties, Judgement& result);
  void renumber(std::size_t next, const std::vector<bool>& stay);

  std::vector<std::optional<Place>> places_;  // the number of one is that of its cell
  // The first node that is not judged yet; it lies on or is tied to a cell, or begins the track.
  std::size_t next_ = 0;
  bool keeps_next_ = false;  // the step into it relates two cells
  bool cut_next_ = false;    // the step into it is cut
  // m driven up to the last node judged that was tied; it may not have stayed
  double tied_at_m_ = -std::numeric_limits<double>::infinity();
  std::map<std::pair<std::size_t, std::size_t>, int> relations_;  // of two cells
};

}  // namespace gprodom
