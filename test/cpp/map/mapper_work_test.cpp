// What the solutions of the pose graph cost in a second of data, where the track is tied to itself
// more and more densely.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

#include "map/mapper.h"

namespace gprodom {
namespace {

constexpr double kSpeed = 1.0;             // m/s, straight ahead
constexpr TimeNs kInterval = 500'000'000;  // ns from state to state: each is a node
constexpr int kAlone = 600, kTied = 200;   // states before the first revisit, and since then
constexpr int kTies = 24;                  // revisits told for a state
constexpr double kWorkPerSecond = 5e7;     // multiplications, NormalMatrix::work()

TimeNs time_of(int state) { return from_seconds(1000.0) + state * kInterval; }

// That a state lies as far from an earlier one as it does, as another process tells it.
Displacement tie(int from, int to) {
  Displacement revisit;
  revisit.kind = DisplacementKind::kRevisit;
  revisit.from = time_of(from);
  revisit.to = time_of(to);
  revisit.distance_m = kSpeed * to_seconds(revisit.to - revisit.from);
  revisit.sigma_m = 0.01;
  revisit.valid = true;
  return revisit;
}

// The ties join places of the whole track, so the factor of the normal equations fills up, and
// what a solution costs grows far faster than the number of its nodes.
TEST(MapperWork, OfASecondIsBoundedWhereTheTrackIsTiedToItselfMoreAndMore) {
  Mapper mapper(default_config(), std::nullopt, std::nullopt);
  std::mt19937 random(1);
  double dearest = 0.0;
  int solutions = 0;
  bool located = false;
  for (int i = 0; i < kAlone + kTied; ++i) {
    MapInput input;
    PathState state;
    state.time = time_of(i);
    state.pose.p.x() = kSpeed * i * to_seconds(kInterval);
    state.covariance = state.pose_covariance = 1e-6 * i * Eigen::Matrix3d::Identity();
    input.states.push_back(state);
    for (int k = 0; k < kTies && i >= kAlone; ++k)
      input.revisits.push_back(tie(static_cast<int>(random() % static_cast<unsigned>(i - 10)), i));
    const double before = mapper.solve_work();
    located = mapper.run(input).pose.has_value();
    const double work = mapper.solve_work() - before;
    if (work > 0.0) ++solutions;
    dearest = std::max(dearest, work);
  }
  // Solved each second, all of them together would cost more than twice as much.
  EXPECT_TRUE(located);
  ASSERT_GT(dearest, 2.0 * kWorkPerSecond);
  EXPECT_GT(solutions, 2);
  const double seconds = to_seconds(kTied * kInterval);
  EXPECT_LT(mapper.solve_work(), kWorkPerSecond * seconds + dearest);
}

}  // namespace
}  // namespace gprodom
