#include "map/pass_merger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "map/pass_finder.h"

namespace gprodom {
namespace {

constexpr double kSpacing = 0.5;  // m between nodes

// The nodes and revisits of a robot on a track, as the graph would have them.
struct Track {
  std::vector<PassMerger::Node> nodes;
  std::vector<RevisitEdge> revisits;
  std::vector<bool> trusted;
  PassMerger merger;

  // ground: the places to which that of the nodes is tied; if there are none, it is new.
  void drive(std::size_t steps, const std::vector<std::size_t>& ground) {
    for (std::size_t i = 0; i < steps; ++i) {
      if (ground.empty())
        add(true, {travelled + kSpacing, 0.0}, std::nullopt);
      else
        add(false, nodes[ground[i % ground.size()]].in_map, ground[i % ground.size()]);
    }
  }
  // Round after round over ground of an earlier track.
  void drive_in_map(std::size_t steps, std::size_t round) {
    for (std::size_t i = 0; i < steps; ++i)
      add(false, {kSpacing * static_cast<double>(i % round), 0.0}, kInMap);
  }
  void add(bool has_ground, const Eigen::Vector2d& place, std::optional<std::size_t> tied_to) {
    travelled += kSpacing;
    nodes.push_back({travelled, has_ground, place});
    cut.push_back(false);
    if (tied_to) {
      revisits.push_back({*tied_to, nodes.size() - 1});
      trusted.push_back(true);
    }
    if (nodes.size() % 10 == 0) merge();
  }
  void merge() {
    const auto [stay, cut_now] = merger.judge(nodes, revisits, trusted);
    ASSERT_EQ(stay.size(), nodes.size());
    std::vector<std::size_t> number;
    std::vector<PassMerger::Node> left;
    std::vector<bool> left_cut;
    bool cuts = false;  // between the last node that stays and this one
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      number.push_back(left.size());
      cuts = cuts || cut[i] || cut_now[i];
      if (!stay[i]) continue;
      left.push_back(nodes[i]);
      left_cut.push_back(std::exchange(cuts, false));
    }
    cut = std::move(left_cut);
    std::vector<RevisitEdge> edges;
    std::vector<bool> left_trusted;
    for (std::size_t i = 0; i < revisits.size(); ++i) {
      RevisitEdge edge = revisits[i];
      if (!stay[edge.query]) continue;
      edge.query = number[edge.query];
      if (edge.memory != kInMap) {
        ASSERT_TRUE(stay[edge.memory]);
        edge.memory = number[edge.memory];
      }
      edges.push_back(edge);
      left_trusted.push_back(trusted[i]);
    }
    nodes = std::move(left);
    revisits = std::move(edges);
    trusted = std::move(left_trusted);
  }

  // Longest step that is not cut, m. What lies between two cuts is tied.
  double longest_step() const {
    double longest = 0.0;
    std::vector<bool> tied(nodes.size());
    for (const RevisitEdge& edge : revisits) {
      tied[edge.query] = true;
      if (edge.memory != kInMap) tied[edge.memory] = true;
    }
    bool piece_tied = tied.front();
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      if (cut[i]) {
        EXPECT_TRUE(piece_tied) << i;
        piece_tied = false;
      } else {
        longest = std::max(longest, nodes[i].travelled_m - nodes[i - 1].travelled_m);
      }
      piece_tied = piece_tied || tied[i];
    }
    EXPECT_TRUE(piece_tied);
    return longest;
  }

  double travelled = 0.0;
  std::vector<bool> cut;  // for each node: the step into it
};

std::vector<std::size_t> all_of(std::size_t first, std::size_t count) {
  std::vector<std::size_t> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = first + i;
  return numbers;
}

TEST(PassMerger, NodesOverTheSameGroundAreBounded) {
  Track track;
  track.drive(20, {});
  track.drive(1000, all_of(0, 20));
  const std::size_t early = track.nodes.size();
  EXPECT_LT(early, 300U);
  track.drive(9000, all_of(0, 20));
  EXPECT_EQ(track.nodes.size(), early);
  // The first passes are those that stay, and are still tied to where they were.
  EXPECT_EQ(track.revisits.front().query, 20U);
  // Revisits move the map as a whole. That does not make its ground new.
  for (int i = 1; i <= 10; ++i) {
    for (PassMerger::Node& node : track.nodes) node.in_map += Eigen::Vector2d(0.3, 0.7);
    track.drive(1000, all_of(0, 20));
  }
  EXPECT_LT(track.nodes.size(), early + 10);
}

// Its places are held, and no pass relates them any better.
TEST(PassMerger, OfGroundOfAnEarlierTrackOnlyTheNewestNodesStay) {
  Track track;
  track.drive_in_map(3000, 400);
  EXPECT_LT(static_cast<double>(track.nodes.size()), 1.2 * PassMerger::kInFull / kSpacing);
  EXPECT_LT(track.longest_step(), 3.0);
}

// Steps over ground that enough passes relate would lead over a whole drive.
TEST(PassMerger, StepsOverWellKnownGroundAreCut) {
  Track track;
  track.drive(200, {});
  for (int lap = 0; lap < 20; ++lap) track.drive(200, all_of(0, 200));
  EXPECT_LT(track.longest_step(), 4.0);
  track.drive(40, {});  // and on to new ground
  for (int lap = 0; lap < 5; ++lap) track.drive(200, all_of(0, 200));
  EXPECT_LT(track.longest_step(), 4.0);
  EXPECT_GT(std::count(track.cut.begin(), track.cut.end(), true), 1);
}

// A robot that wanders stores several passes over a place, and is tied now to one, now to another.
TEST(PassMerger, NodesOverSeveralPassesOfTheSameGroundAreBoundedAsOverOne) {
  Track track;
  for (int pass = 0; pass < 5; ++pass) {
    track.drive(20, {});
    for (std::size_t i = 1; i <= 20; ++i)
      track.nodes[track.nodes.size() - i].in_map = {kSpacing * static_cast<double>(20 - i), 0.0};
  }
  std::vector<std::size_t> ties(1000);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < ties.size(); ++i) ties[i] = i % 20 + 20 * (random() % 5);
  track.drive(1000, ties);
  EXPECT_LT(track.nodes.size(), 100U + 300U);
  const std::size_t early = track.nodes.size();
  track.drive(9000, ties);
  EXPECT_EQ(track.nodes.size(), early);
}

// How many more nodes there are after 20 passes over known ground, in each of which 12 nodes
// between two revisits are not recognised.
std::size_t nodes_more(bool with_ground, bool with_fix) {
  Track track;
  track.drive(20, {});
  track.drive(1000, all_of(0, 20));
  const std::size_t early = track.nodes.size();
  for (int pass = 0; pass < 20; ++pass) {
    track.drive(4, all_of(0, 4));
    for (int i = 0; i < 12; ++i) {
      track.drive(1, {});
      track.nodes.back().has_ground = with_ground;
      track.nodes.back().has_fix = with_fix;
    }
    track.drive(4, all_of(16, 4));
    track.drive(100, all_of(0, 20));
  }
  return track.nodes.size() - early;
}

// What lies between two revisits that are not far apart says no more than the odometry between
// them, unless it holds stored ground or a fix.
TEST(PassMerger, NodesThatWereNotRecognisedBetweenRevisitsDoNotStay) {
  // The jumps are between places that no pass joined before: some nodes stay for them.
  EXPECT_LT(nodes_more(false, false), 40U);
  EXPECT_GE(nodes_more(true, false), 240U);
  EXPECT_GE(nodes_more(false, true), 240U);
}

// It is recognised now here, now there: where one stretch ends and the next one begins is new each
// time, but says nothing of the map.
TEST(PassMerger, StretchesThatAreRecognisedAnywhereAddNoRelations) {
  Track track;
  track.drive(400, {});
  std::mt19937 random(1);
  const auto round = [&] {
    for (std::size_t at = 0; at < 350;) {
      const std::size_t gap = 10 + random() % 20, known = 4 + random() % 10;
      track.drive(gap, all_of(at, gap));
      for (std::size_t i = 1; i <= gap; ++i) {  // not recognised
        track.trusted[track.trusted.size() - i] = false;
      }
      track.drive(known, all_of(at + gap, known));
      at += gap + known;
    }
  };
  for (int i = 0; i < 100; ++i) round();
  const std::size_t early = track.nodes.size();
  for (int i = 0; i < 100; ++i) round();
  EXPECT_LT(track.nodes.size(), early + 20U);
}

// Where enough passes are stored side by side, nothing is stored, and perhaps no revisit is found
// over tens of metres.
TEST(PassMerger, LongStretchesThatWereNotRecognisedDoNotStayWhereTheWayIsKnown) {
  Track track;
  track.drive(200, {});
  track.drive(2000, all_of(0, 200));
  const auto round = [&track](double aside) {
    track.drive(60, all_of(0, 60));
    track.drive(80, {});  // 40 m
    for (std::size_t i = 0; i < 80; ++i) {
      PassMerger::Node& node = track.nodes[track.nodes.size() - 80 + i];
      node.has_ground = false;
      node.in_map = track.nodes[60 + i].in_map + Eigen::Vector2d(0.0, aside);
    }
    track.drive(60, all_of(140, 60));
  };
  const std::size_t early = track.nodes.size();
  for (int i = 0; i < 20; ++i) round(0.3);
  track.drive(400, all_of(0, 200));
  EXPECT_LT(track.nodes.size(), early + 100U);  // the newest ones all stay
  track.longest_step();
  for (int i = 0; i < 4; ++i) round(5.0);  // another way
  track.drive(400, all_of(0, 200));
  EXPECT_GT(track.nodes.size(), early + 250U);
}

TEST(PassMerger, NodesThatJoinPlacesOfTheMapStay) {
  Track track;
  track.drive(40, {});
  track.drive(2000, all_of(0, 20));  // well known
  track.drive(40, {});               // somewhere else
  const std::size_t there = track.nodes.size() - 40;
  const double leave = track.nodes[there].travelled_m;
  track.drive(1, {20});
  track.drive(2000, all_of(21, 19));
  // One revisit where the new ground begins, and one where it ends.
  bool before = false, after = false;
  for (const RevisitEdge& edge : track.revisits) {
    const double at = track.nodes[edge.query].travelled_m;
    before = before || (at < leave && at > leave - 2.5);
    after = after || (at > leave + 19.0 && at < leave + 22.0);
  }
  EXPECT_TRUE(before);
  EXPECT_TRUE(after);
}

TEST(PassMerger, WithoutRevisitsAllNodesStay) {
  Track track;
  track.drive(400, {});
  for (auto& node : track.nodes) node.has_ground = false;  // the memory has forgotten it
  track.drive(200, {});
  EXPECT_EQ(track.nodes.size(), 600U);
}

// Five laps of a square of 10 m a side, each a little further to the left.
TEST(PassFinder, NearestAndNewestPassComeFirst) {
  const PlanarPose here{{5.0, 0.1}, 0.0};
  PassFinder finder(here, 1.0, 0.5, 0.0);
  std::size_t place = 0;
  for (const double aside : {0.0, 0.09, 0.02, 0.04, 0.35}) {
    for (int i = 0; i < 20; ++i) finder.offer(place++, {{0.5 * i, aside}, 0.0}, false);
    for (int i = 0; i < 20; ++i) finder.offer(place++, {{10.0, 0.5 * i}, 1.57}, false);
  }
  ASSERT_EQ(finder.passes().size(), 5U);
  const auto order = in_search_order(finder.passes(), 0.15);
  ASSERT_EQ(order.size(), 5U);
  EXPECT_EQ(order[0].place, 50U);   // 1 cm aside
  EXPECT_EQ(order[1].place, 130U);  // the newest but for the one 25 cm aside
  EXPECT_EQ(order[4].place, 170U);
}

TEST(PassFinder, PassInTheOppositeDirectionIsTurned) {
  for (const bool turned : {false, true}) {
    PassFinder finder({{1.0, 0.0}, 0.1}, 1.0, 0.5, 0.0);
    finder.offer(0, {{1.2, 0.1}, turned ? M_PI : 0.0}, false);
    ASSERT_EQ(finder.passes().size(), 1U);
    EXPECT_EQ(finder.passes()[0].turned, turned);
    EXPECT_NEAR(finder.passes()[0].along, turned ? 0.2 : -0.2, 1e-9);
  }
}

}  // namespace
}  // namespace gprodom
