#include "map/merge/map_merge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "driven_ground.h"

namespace gprodom {
namespace {

// How the second session's frame lies in the first's.
const PlanarPose kOther{{10.0, 3.0}, 2.0};

GroundMap session(unsigned seed, double begin, double end, unsigned noise,
                  double wave_speed = 1e8) {
  GroundMap ground{gpr::TraceMemoryOptions()};
  drive(ground, seed, begin, end, noise, wave_speed);
  ground.identity = noise;
  return ground;
}

GroundMap in_own_frame(GroundMap ground) {
  for (KnownPlace& place : ground.places) place.pose = compose(between(kOther, {}), place.pose);
  return ground;
}

double metres(const GroundMap& ground) { return stored_m(ground.memory); }

// Of places, given in the same order, from where they should lie.
double worst(const std::vector<KnownPlace>& places, const std::vector<KnownPlace>& truth) {
  double most = places.size() == truth.size() ? 0.0 : HUGE_VAL;
  for (std::size_t i = 0; i < places.size() && i < truth.size(); ++i)
    most = std::max(most, (places[i].pose.p - truth[i].pose.p).norm());
  return most;
}

// Of all places of two maps, after merging.
double worst_of_both(const MergedMaps& merged, const GroundMap& first, const GroundMap& second) {
  std::vector<KnownPlace> truth = first.places;
  truth.insert(truth.end(), second.places.begin(), second.places.end());
  return worst(merged.joins.at(0).joined->places, truth);
}

TEST(MapMerge, TwoSessionsBecomeOne) {
  const GroundMap first = session(3, 1.0, 25.0, 1);
  for (const double wave_speed : {1e8, 1.04e8}) {
    const GroundMap second = session(3, 12.0, 38.0, 2, wave_speed);
    const MergedMaps merged = merge_maps(first, in_own_frame(second), {});
    ASSERT_EQ(merged.joins.size(), 1U);
    EXPECT_TRUE(merged.joins[0].proven);
    EXPECT_NEAR(merged.joins[0].joined->change.stretch, -std::log(wave_speed / 1e8), 0.02);
    EXPECT_EQ(merged.ground.parents, (std::vector<std::uint64_t>{1, 2}));
    EXPECT_EQ(merged.ground.memory.sessions().size(), 2U);
    EXPECT_EQ(merged.ground.unused_map(), 1);
    // Known ground is not stored twice.
    EXPECT_NEAR(metres(merged.ground), 37.0, 2.5);
    EXPECT_NEAR(metres(merged.ground) + merged.known_m, metres(first) + metres(second), 0.01);
    // What reaches 13 m beyond the common ground is tied to it by its heading.
    EXPECT_LT(worst_of_both(merged, first, second), 0.3);
    const GroundMap back = reloaded(merged.ground);
    EXPECT_EQ(back.parents, merged.ground.parents);
    EXPECT_EQ(back.places.size(), merged.ground.places.size());
  }
}

TEST(MapMerge, DrivenTheOtherWay) {
  const GroundMap first = session(3, 1.0, 25.0, 1), second = session(3, 24.0, 4.0, 2);
  const MergedMaps merged = merge_maps(first, in_own_frame(second), {});
  ASSERT_TRUE(merged.joins.at(0).proven);
  EXPECT_LT(worst_of_both(merged, first, second), 0.1);
}

TEST(MapMerge, GroundOfAStrangerChangesNothing) {
  const GroundMap first = session(3, 1.0, 25.0, 1);
  const MergedMaps merged = merge_maps(first, session(4, 1.0, 25.0, 2), {});
  EXPECT_FALSE(merged.joins.at(0).proven);
  EXPECT_EQ(merged.known_m, 0.0);
  EXPECT_EQ(merged.ground.parents, std::vector<std::uint64_t>{1});
  EXPECT_LT(worst(merged.ground.places, first.places), 1e-9);
  EXPECT_EQ(merged.ground.memory.kept().size(), first.memory.kept().size());
}

// A stretch that looks alike is no proof, since what follows it differs.
TEST(MapMerge, AShortPieceInCommonIsNoProof) {
  const GroundMap first = session(3, 1.0, 25.0, 1);
  GroundMap second = session(3, 8.0, 14.8, 2);
  drive(second, 4, 14.8, 30.0, 3);
  const MergedMaps merged = merge_maps(first, in_own_frame(std::move(second)), {});
  EXPECT_FALSE(merged.joins.at(0).proven);
  EXPECT_LT(worst(merged.ground.places, first.places), 1e-9);
}

// How the first session's frame lies in site, and how surely: about its first places.
const PlanarPose kSite{{500.0, -200.0}, 0.7};

MapDatum datum(const PlanarPose& pose, double sigma_m, double sigma_yaw) {
  MapDatum datum;
  datum.pose = pose;
  datum.covariance = Eigen::Vector4d(sigma_m, sigma_m, 1.0, sigma_yaw).cwiseAbs2().asDiagonal();
  return datum;
}

struct TwoDays {
  GroundMap first, second;
};

// On different ground, or on the same; both are tied to one site.
TwoDays tied_days(unsigned other_ground, double sigma_yaw) {
  TwoDays days{session(3, 1.0, 25.0, 1), session(other_ground, 1.0, 25.0, 2)};
  days.first.datums[0] = datum(kSite, 0.03, sigma_yaw);
  days.second = in_own_frame(std::move(days.second));
  days.second.datums[0] = datum(compose(kSite, kOther), 0.03, sigma_yaw);
  return days;
}

TEST(MapMerge, TwoDaysOfOneSiteNeedNoGroundInCommon) {
  const TwoDays days = tied_days(4, 0.002);
  const MergedMaps merged = merge_maps(days.first, days.second, {});
  const MapJoin& join = merged.joins.at(0);
  ASSERT_TRUE(join.proven && join.by_datum);
  EXPECT_LT(worst_of_both(merged, days.first, session(4, 1.0, 25.0, 2)), 1e-6);
  EXPECT_EQ(merged.ground.unused_map(), 1);
  EXPECT_NEAR(metres(merged.ground), metres(days.first) + metres(days.second), 1e-9);
  EXPECT_EQ(merged.ground.datums.size(), 1U);
  // 25 m from where both are known to 3 cm and 0.002 rad, with 10 cm of each path.
  const double sigma = std::sqrt(join.joined->end.covariance.topLeftCorner<2, 2>().trace());
  EXPECT_NEAR(sigma, 0.22, 0.03);
}

TEST(MapMerge, ADatumThatIsTooUncertainJoinsNothing) {
  const TwoDays days = tied_days(4, 0.08);
  EXPECT_FALSE(merge_maps(days.first, days.second, {}).joins.at(0).proven);
}

TEST(MapMerge, SitesThatAreNotTheSameJoinNothing) {
  TwoDays days = tied_days(4, 0.002);
  days.second.datums[0].origin = Geodetic(52.0, 13.0, 40.0);
  EXPECT_FALSE(merge_maps(days.first, days.second, {}).joins.at(0).proven) << "one is not known";
  days.first.datums[0].origin = Geodetic(48.0, 11.0, 40.0);
  EXPECT_FALSE(merge_maps(days.first, days.second, {}).joins.at(0).proven) << "too far apart";
  // One site by two origins, 100 m to the north of each other.
  days.first.datums[0].origin = Geodetic(52.0, 13.0, 40.0);
  const Eigen::Vector3d north(0.0, 100.0, 0.0);
  days.second.datums[0].origin = Datum(*days.first.datums[0].origin).to_geodetic(north);
  days.second.datums[0].pose.p.y() -= 100.0;
  const MergedMaps merged = merge_maps(days.first, days.second, {});
  ASSERT_TRUE(merged.joins.at(0).by_datum);
  EXPECT_LT(worst_of_both(merged, days.first, session(4, 1.0, 25.0, 2)), 1e-2);
}

TEST(MapMerge, GroundGoesBeforeTheDatumAndChecksIt) {
  TwoDays days = tied_days(3, 0.002);
  const MergedMaps agreed = merge_maps(days.first, days.second, {});
  ASSERT_TRUE(agreed.joins.at(0).proven && agreed.joins[0].check);
  EXPECT_FALSE(agreed.joins[0].by_datum);
  EXPECT_TRUE(agreed.joins[0].check->agrees()) << agreed.joins[0].check->deviations;
  days.second.datums[0].pose.p.x() += 3.0;
  const MergedMaps apart = merge_maps(days.first, days.second, {});
  EXPECT_LT(worst_of_both(apart, days.first, session(3, 1.0, 25.0, 2)), 0.3);
  ASSERT_TRUE(apart.joins.at(0).check);
  EXPECT_FALSE(apart.joins[0].check->agrees());
  EXPECT_NEAR(apart.joins[0].check->off_m, 3.0, 0.3);
}

TEST(MapMerge, TheDatumOfTheSecondIsThatOfBoth) {
  TwoDays days = tied_days(3, 0.002);
  days.first.datums.clear();
  const MergedMaps merged = merge_maps(days.first, days.second, {});
  ASSERT_EQ(merged.ground.datums.count(0), 1U);
  const MapDatum& found = merged.ground.datums.at(0);
  EXPECT_LT((found.pose.p - kSite.p).norm(), 0.6) << "by a heading, 20 m from there";
  EXPECT_NEAR(found.pose.yaw, kSite.yaw, 0.03);
  EXPECT_GT(std::sqrt(found.covariance(3, 3)), 0.002);
}

TEST(MapMerge, WhatCannotBeComparedIsRefused) {
  const GroundMap first = session(3, 1.0, 12.0, 1);
  GroundMap other = session(3, 1.0, 12.0, 2);
  other.format.sample_interval_s *= 2;
  EXPECT_THROW(merge_maps(first, other, {}), std::invalid_argument);
  EXPECT_THROW(merge_maps(first, first.features_alone(), {}), std::invalid_argument);
  EXPECT_THROW(merge_maps(GroundMap{gpr::TraceMemoryOptions()}, first, {}), std::invalid_argument);
}

}  // namespace
}  // namespace gprodom
