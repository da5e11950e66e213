#include "map/pass_merger.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gprodom {
namespace {

constexpr double kCell = 2.0;     // m, from the middle of a cell
constexpr double kNearTie = 2.0;  // m driven; a node so near to a revisit lies on tied ground
// m driven from one revisit to the next, if the ground between them was not recognised. The yaw of
// a joined step of this length is known to far less than 0.1 rad, so that it stays linear.
constexpr double kBetweenTies = 20.0;
constexpr int kRelations = 4;  // passes that stay for each pair of cells
// m driven from a cell to one that it is related to. In a longer gap the ground is stored, or it is
// ground of which enough is stored: the map knows the way without this pass. (Of new ground that is
// shorter, nothing is stored: TraceMemoryOptions::least_m.)
constexpr double kOneWay = 3.5;

std::pair<int, int> square_at(const Eigen::Vector2d& p) {
  const Eigen::Vector2d corner = (p / kCell).array().floor();
  return {static_cast<int>(corner.x()), static_cast<int>(corner.y())};
}

}  // namespace

// Which nodes trusted revisits tie to known ground, and which may go: those near such a node.
class PassMerger::Ties {
 public:
  std::vector<std::optional<std::size_t>> to;  // for each node, the older node, or kInMap
  // Nothing holds it, and it lies on tied ground.
  bool can_go(std::size_t node) const { return near_[node] && is_free(node); }
  // Nothing holds it: neither ground nor a fix nor a revisit of it.
  bool is_free(std::size_t node) const { return free_[node]; }

  // last: m driven up to the last tie before the nodes that are judged now.
  Ties(const std::vector<Node>& nodes, const std::vector<RevisitEdge>& revisits,
       const std::vector<bool>& trusted, double last)
      : to(nodes.size()), near_(nodes.size()), free_(nodes.size()) {
    std::vector<bool> is_memory(nodes.size());
    for (std::size_t i = 0; i < revisits.size(); ++i) {
      const RevisitEdge& edge = revisits[i];
      if (edge.memory != kInMap) is_memory[edge.memory] = true;
      if (i < trusted.size() && trusted[i]) to[edge.query] = edge.memory;
    }
    constexpr double kNone = std::numeric_limits<double>::infinity();
    std::vector<double> since(nodes.size());  // m driven since the last tie
    double next = kNone;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (to[i]) last = std::max(last, nodes[i].travelled_m);
      since[i] = nodes[i].travelled_m - last;
    }
    for (std::size_t i = nodes.size(); i-- > 0;) {
      if (to[i]) next = nodes[i].travelled_m;
      const double until = next - nodes[i].travelled_m;
      near_[i] = std::min(since[i], until) <= kNearTie || since[i] + until <= kBetweenTies;
      free_[i] = i > 0 && !nodes[i].has_ground && !nodes[i].has_fix && !is_memory[i];
    }
  }

 private:
  std::vector<bool> near_, free_;
};

// Finds the cell of a node, or makes one. Cells move with the map: by coordinates, a map that comes
// to lie a metre aside would be all new.
class PassMerger::Cells {
 public:
  Cells(std::vector<std::optional<Place>>& places, const std::vector<Node>& nodes)
      : places_(places), nodes_(nodes) {
    for (std::size_t i = 0; i < places.size(); ++i)
      if (places[i]) squares_[square_at(position(*places[i]))].push_back(i);
  }

  // node: that of the place, should it be new; kInMap: it is held where it is now.
  std::size_t at(const Eigen::Vector2d& p, std::size_t node) {
    if (const auto found = find(p)) return *found;
    places_.push_back(Place{node, p});
    squares_[square_at(position(*places_.back()))].push_back(places_.size() - 1);
    return places_.size() - 1;
  }

  std::optional<std::size_t> find(const Eigen::Vector2d& p) const {
    std::optional<std::size_t> found;
    double least = kCell;
    const auto [x, y] = square_at(p);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto square = squares_.find({x + dx, y + dy});
        if (square == squares_.end()) continue;
        for (std::size_t i : square->second) {
          const double apart = (position(*places_[i]) - p).norm();
          if (apart >= least) continue;
          found = i;
          least = apart;
        }
      }
    }
    return found;
  }

 private:
  const Eigen::Vector2d& position(const Place& place) const {
    return place.node == kInMap ? place.p : nodes_[place.node].in_map;
  }
  std::vector<std::optional<Place>>& places_;
  const std::vector<Node>& nodes_;
  std::map<std::pair<int, int>, std::vector<std::size_t>> squares_;
};

// The nodes that are judged now, and the first one after them.
struct PassMerger::Piece {
  std::size_t first, end;
  // For each node from `first` to `end`. kept: it is an end of a step that relates two cells and
  // stays. known: enough other passes relate the two cells of the step into it.
  std::vector<bool> kept, known;
  std::vector<bool> passed;  // it lies between ties further apart, on a way that is known

  bool is_kept(std::size_t node) const { return kept[node - first]; }
  // Of the steps from one node to another.
  bool is_known(std::size_t from, std::size_t to) const {
    for (std::size_t i = std::max(from + 1, first); i <= to; ++i)
      if (known[i - first]) return true;
    return false;
  }
};

PassMerger::Judgement PassMerger::judge(const std::vector<Node>& nodes,
                                        const std::vector<RevisitEdge>& revisits,
                                        const std::vector<bool>& trusted) {
  Judgement result{std::vector<bool>(nodes.size(), true), std::vector<bool>(nodes.size(), false)};
  const Ties ties(nodes, revisits, trusted, tied_at_m_);
  const std::optional<Piece> piece = next_piece(nodes, ties);
  if (!piece) return result;
  for (std::size_t i = piece->first; i < piece->end; ++i) {
    const bool can_go = ties.can_go(i) || piece->passed[i - piece->first];
    result.stay[i] = piece->is_kept(i) || !can_go;
    if (ties.to[i]) tied_at_m_ = nodes[i].travelled_m;
  }
  cut(*piece, ties, result);
  renumber(piece->end, result.stay);
  return result;
}

// Two nodes stay if few passes so far relate the cell of one to that of the other. What lies in the
// same cell is known well enough by one node.
std::optional<PassMerger::Piece> PassMerger::next_piece(const std::vector<Node>& nodes,
                                                        const Ties& ties) {
  const double behind = nodes.back().travelled_m - kInFull;
  std::vector<Visit> visits;
  Cells cells(places_, nodes);
  for (std::size_t i = next_; i < nodes.size() && nodes[i].travelled_m < behind; ++i) {
    if (!nodes[i].has_ground && !ties.to[i]) continue;
    const std::size_t owner = nodes[i].has_ground ? i : *ties.to[i];
    visits.push_back({i, cells.at(nodes[owner == kInMap ? i : owner].in_map, owner)});
  }
  if (visits.empty() || visits.back().node == next_) return std::nullopt;
  const std::size_t size = visits.back().node + 1 - next_;
  const std::vector<bool> none(size);
  Piece piece{next_, visits.back().node, none, none, none};
  piece.kept.front() = keeps_next_;
  piece.known.front() = cut_next_;
  for (std::size_t k = 1; k < visits.size(); ++k) {
    const Visit &a = visits[k - 1], &b = visits[k];
    const bool near = nodes[b.node].travelled_m - nodes[a.node].travelled_m <= kOneWay;
    if (!near && is_known_way(nodes, ties, cells, a, b)) {
      for (std::size_t i = a.node + 1; i < b.node; ++i)
        piece.known[i - next_] = piece.passed[i - next_] = true;
    }
    if (a.cell == b.cell || !near || (!ties.can_go(a.node) && !ties.can_go(b.node))) continue;
    if (!are_known(a.cell, b.cell)) {
      ++relations_[std::minmax(a.cell, b.cell)];
      piece.kept[a.node - next_] = piece.kept[b.node - next_] = true;
    } else {
      piece.known[b.node - next_] = true;
    }
  }
  keeps_next_ = piece.kept.back();
  return piece;
}

// Whether enough passes relate the cells on the way from one visit to the next, where no revisit
// was found and nothing was stored. Its nodes would stay, and on the same ground there would be
// more of them with each pass.
bool PassMerger::is_known_way(const std::vector<Node>& nodes, const Ties& ties, const Cells& cells,
                              const Visit& a, const Visit& b) const {
  std::size_t last = a.cell;
  const auto leads_to = [&](std::size_t cell) {
    return are_known(std::exchange(last, cell), cell);
  };
  for (std::size_t i = a.node + 1; i < b.node; ++i) {
    const auto cell = cells.find(nodes[i].in_map);
    if (!ties.is_free(i) || !cell || (*cell != last && !leads_to(*cell))) return false;
  }
  return b.cell == last || leads_to(b.cell);
}

// Whether no further pass needs to relate two cells: places that are held do not move.
bool PassMerger::are_known(std::size_t a, std::size_t b) const {
  const auto is_held = [&](std::size_t cell) { return places_[cell]->node == kInMap; };
  const auto found = relations_.find(std::minmax(a, b));
  return (is_held(a) && is_held(b)) || (found != relations_.end() && found->second >= kRelations);
}

// Where nodes go because enough passes relate their cells, the others are not joined: such steps
// would lead ever further, and many of them side by side make a solution expensive. Both ends of a
// cut need a tie.
void PassMerger::cut(const Piece& piece, const Ties& ties, Judgement& result) {
  std::vector<bool>& stay = result.stay;
  cut_next_ = false;
  std::size_t from = stay[piece.first] ? piece.first : piece.first - 1;  // the last that stays
  for (std::size_t to = from + 1; to <= piece.end; ++to) {
    if (!stay[to]) continue;
    std::size_t left = from, right = to;
    while (right > from && !ties.to[right]) --right;
    while (left < right && !ties.to[left]) ++left;
    if (left + 1 < right && piece.is_known(left, right)) {
      stay[left] = stay[right] = result.cut[right] = true;
      cut_next_ = right == piece.end;
    }
    from = to;
  }
}

void PassMerger::renumber(std::size_t next, const std::vector<bool>& stay) {
  std::vector<std::size_t> number;  // of those that stay
  for (std::size_t i = 0, left = 0; i < stay.size(); left += stay[i++]) number.push_back(left);
  for (std::optional<Place>& place : places_) {
    if (!place || place->node == kInMap) continue;
    if (stay[place->node])
      place->node = number[place->node];
    else
      place.reset();
  }
  next_ = number[next];
}

}  // namespace gprodom
