#include "motion/radar_finding.h"

#include <gtest/gtest.h>

namespace gprodom {
namespace {

constexpr TimeNs kFrom = 1'000'000'000, kTo = 2'000'000'000;

void expect_said(const Displacement& d, DisplacementKind kind, bool valid, double distance_m) {
  EXPECT_EQ(d.from, kFrom);
  EXPECT_EQ(d.to, kTo);
  EXPECT_EQ(d.source, "mine");
  EXPECT_EQ(d.kind, kind);
  EXPECT_EQ(d.valid, valid);
  EXPECT_DOUBLE_EQ(d.distance_m, distance_m);
  EXPECT_EQ(d.score, 0.6);
}

TEST(RadarFinding, StandstillIsPublishedAsMotionWithZeroDistance) {
  const Displacement d = to_displacement(gpr::Standstill{kFrom, kTo, "mine", 1e-3, 0.6});
  expect_said(d, DisplacementKind::kMotion, true, 0.0);
  EXPECT_EQ(d.sigma_m, 1e-3);
}

TEST(RadarFinding, ADisplacementAlongTheTrackKeepsItsSignAndValidity) {
  const Displacement d =
      to_displacement(gpr::TrackDisplacement{kFrom, kTo, "mine", false, -0.2, 0.05, 0.6});
  expect_said(d, DisplacementKind::kSequential, false, -0.2);
  EXPECT_EQ(d.sigma_m, 0.05);
}

TEST(RadarFinding, PathLengthIsPublishedInMetresWithItsScale) {
  const Displacement d = to_displacement(gpr::PathLength{kFrom, kTo, "mine", true, 8.0, 0.6}, 0.05);
  expect_said(d, DisplacementKind::kMotion, true, 0.4);
  EXPECT_EQ(d.scale, 0.05);
}

}  // namespace
}  // namespace gprodom
