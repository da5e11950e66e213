#include "motion/radar_finding.h"

#include <gtest/gtest.h>

namespace gprodom {
namespace {

TEST(RadarFinding, StandstillIsPublishedAsMotionWithZeroDistance) {
  const Displacement d =
      to_displacement(gpr::Standstill{from_seconds(1), from_seconds(2), "mine", 1e-3, 0.9});
  EXPECT_EQ(d.from, from_seconds(1));
  EXPECT_EQ(d.to, from_seconds(2));
  EXPECT_EQ(d.source, "mine");
  EXPECT_EQ(d.kind, DisplacementKind::kMotion);
  EXPECT_TRUE(d.valid);
  EXPECT_EQ(d.distance_m, 0.0);
  EXPECT_EQ(d.sigma_m, 1e-3);
  EXPECT_EQ(d.score, 0.9);
}

TEST(RadarFinding, ADisplacementAlongTheTrackKeepsItsSignAndValidity) {
  gpr::TrackDisplacement measured;
  measured.from = from_seconds(1);
  measured.to = from_seconds(1.5);
  measured.source = "mine";
  measured.distance_m = -0.2;
  measured.sigma_m = 0.05;
  measured.score = 0.7;
  const Displacement d = to_displacement(measured);
  EXPECT_EQ(d.from, measured.from);
  EXPECT_EQ(d.to, measured.to);
  EXPECT_EQ(d.source, "mine");
  EXPECT_EQ(d.kind, DisplacementKind::kSequential);
  EXPECT_FALSE(d.valid);
  EXPECT_EQ(d.distance_m, -0.2);
  EXPECT_EQ(d.sigma_m, 0.05);
  EXPECT_EQ(d.score, 0.7);
}

TEST(RadarFinding, PathLengthIsPublishedInMetresWithItsScale) {
  const gpr::PathLength path{from_seconds(1), from_seconds(2), "mine", true, 8.0, 0.6};
  const Displacement d = to_displacement(path, 0.05);
  EXPECT_EQ(d.from, path.from);
  EXPECT_EQ(d.to, path.to);
  EXPECT_EQ(d.source, "mine");
  EXPECT_EQ(d.kind, DisplacementKind::kMotion);
  EXPECT_TRUE(d.valid);
  EXPECT_DOUBLE_EQ(d.distance_m, 0.4);
  EXPECT_EQ(d.scale, 0.05);
  EXPECT_EQ(d.score, 0.6);
}

}  // namespace
}  // namespace gprodom
