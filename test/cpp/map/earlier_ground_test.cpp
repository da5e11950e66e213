// The ground of earlier tracks without that of the present one.
#include <gtest/gtest.h>

#include "gpr/synthetic_ground.h"
#include "map/mapper.h"

namespace gprodom {
namespace {

constexpr double kSpeed = 0.5;             // m/s
constexpr TimeNs kInterval = 200'000'000;  // ns from state to state

// 20 m straight ahead over that ground.
void drive(Mapper& mapper, unsigned ground, double begin_s) {
  const gpr::SyntheticGround there(ground, 20.0);
  gpr::SyntheticRadar radar(ground, 60.0);
  MapInput input;
  for (int i = 0; i < 200; ++i) {
    PathState state;
    const double seconds = begin_s + i * to_seconds(kInterval);
    state.time = from_seconds(seconds);
    state.pose.p.x() = kSpeed * i * to_seconds(kInterval);
    state.covariance = state.pose_covariance = 1e-8 * i * Eigen::Matrix3d::Identity();
    input.states.push_back(state);
    for (int k = 0; k < 3 && i > 0; ++k) {
      const double ago = k * to_seconds(kInterval) / 3;
      input.traces.insert(input.traces.end() - k,
                          radar.measure(there, state.pose.p.x() - kSpeed * ago, seconds - ago));
    }
    if (i % 10 < 9) continue;
    mapper.run(input);
    input = {};
  }
}

TEST(EarlierGround, IsWhatWasThereBeforeTheTrack) {
  const auto before = [] {
    Mapper first(default_config(), std::nullopt, std::nullopt);
    drive(first, 1, 1000.0);
    return first.take_ground();
  };
  const auto columns = before().memory.kept().size();
  ASSERT_GT(columns, 500U);

  Mapper second(default_config(), before(), std::nullopt);
  drive(second, 2, 2000.0);
  const GroundMap all = second.take_ground();
  EXPECT_GT(all.memory.kept().size(), columns + 500);

  Mapper third(default_config(), before(), std::nullopt);
  drive(third, 2, 2000.0);
  const GroundMap earlier = third.take_earlier_ground();
  EXPECT_EQ(earlier.memory.kept().size(), columns);
  EXPECT_EQ(earlier.places.size(), before().places.size());

  Mapper alone(default_config(), std::nullopt, std::nullopt);
  drive(alone, 3, 3000.0);
  EXPECT_EQ(alone.take_earlier_ground().memory.kept().size(), 0U);
}

}  // namespace
}  // namespace gprodom
