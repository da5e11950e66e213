// How a map's frame lies in site: what fixes tell of it, and a tie that goes on from a stored one.
#include "map/fixes/map_datum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "driven_ground.h"
#include "map/mapper.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(MapDatum, ThereAndBackOnTheEarth) {
  MapDatum datum;
  EXPECT_FALSE(on_earth(datum));
  datum.origin = Geodetic(52.0, 13.0, 40.0);
  datum.pose = {{30.0, 400.0}, 0.5};
  const FrameOnEarth frame = *on_earth(datum);
  EXPECT_NEAR((Datum(*datum.origin).to_site(frame.origin) - Vector3d(30, 400, 0)).norm(), 0, 1e-6);
  EXPECT_NEAR(frame.yaw, 0.5, 1e-4);
  const MapDatum there = *in_site_of(datum, frame.origin);
  EXPECT_LT(there.pose.p.norm(), 1e-3);
  const MapDatum back = *in_site_of(there, datum.origin);
  EXPECT_LT((back.pose.p - datum.pose.p).norm(), 0.01);
  EXPECT_NEAR(back.pose.yaw, 0.5, 1e-6);
  EXPECT_FALSE(in_site_of(datum, std::nullopt));
  EXPECT_FALSE(in_site_of(datum, Geodetic(48.0, 11.0, 0.0)));
}

// Fixes along x, every metre from `from` to `to`, their errors white with this sigma.
struct Fixed {
  std::vector<FixEdge> fixes;
  std::vector<PlanarPose> places;
};

Fixed along_x(double from, double to, double sigma, const PlanarPose& moved, unsigned seed) {
  Noise normal(seed);
  Fixed all;
  for (double x = from; x < to; x += 1.0) {
    FixEdge fix;
    fix.covariance = sigma * sigma * Eigen::Matrix2d::Identity();
    all.places.push_back({{x, 2.0}, 0.0});
    fix.p = compose(moved, all.places.back()).p + Vector2d(normal(sigma), normal(sigma));
    all.fixes.push_back(fix);
  }
  return all;
}

// By least squares: independent errors along a line of n places a metre apart.
TEST(MapDatum, FixesTellTheMapsPlaceAsWellAsLeastSquaresDo) {
  const PlanarPose moved{{0.4, -0.3}, 0.002};
  double square = 0.0;
  constexpr int kSeeds = 200;
  Matrix3d covariance;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const Fixed all = along_x(100.0, 150.0, 0.05, moved, seed);
    const RigidTie tie = tie_rigidly(all.fixes, all.places, std::nullopt);
    covariance = tie.covariance;
    Vector3d off;
    off << tie.by.p - moved.p, tie.by.yaw - moved.yaw;
    square += off.dot(covariance.inverse() * off) / kSeeds;
  }
  EXPECT_NEAR(square, 3.0, 0.6) << "three degrees of freedom";
  EXPECT_NEAR(std::sqrt(covariance(2, 2)), 0.05 / std::sqrt(50.0 * (2500 - 1) / 12), 1e-5);
  const Matrix3d middle = carried(covariance, {124.5, 2.0});
  EXPECT_NEAR(std::sqrt(middle(0, 0)), 0.05 / std::sqrt(50.0), 1e-4);
}

TEST(MapDatum, ManyFixesOfOneLastingErrorAreHardlyMoreThanOne) {
  Fixed all = along_x(0.0, 50.0, 1.0, {}, 1);
  for (std::size_t i = 0; i < all.fixes.size(); ++i) {
    all.fixes[i].white = 0.05;
    if (i > 0) all.fixes[i].before = i - 1;
    all.fixes[i].kept = 0.999;
  }
  const RigidTie tie = tie_rigidly(all.fixes, all.places, std::nullopt);
  EXPECT_GT(std::sqrt(carried(tie.covariance, {25.0, 2.0})(0, 0)), 0.9);
}

TEST(MapDatum, WhatWasKnownCountsByItsSigma) {
  const Fixed all = along_x(-5.0, 5.0, 0.05, {{0.3, 0.0}, 0.0}, 1);
  const auto sure = [](double sigma) -> Matrix3d {
    return Vector3d(sigma, sigma, 1e-3).cwiseAbs2().asDiagonal();
  };
  const RigidTie free = tie_rigidly(all.fixes, all.places, KnownTie{sure(1.0), sure(0.01)});
  EXPECT_NEAR(free.by.p.x(), 0.3, 0.05);
  EXPECT_LT(free.worst, 4.7);
  // It is the track that is off in its map.
  const RigidTie track = tie_rigidly(all.fixes, all.places, KnownTie{sure(0.01), sure(1.0)});
  EXPECT_LT(std::abs(track.by.p.x()), 0.01);
  EXPECT_LT(track.worst, 4.7);
  EXPECT_NEAR(std::sqrt(track.covariance(0, 0)), 0.01, 1e-4);
  const RigidTie held = tie_rigidly(all.fixes, all.places, KnownTie{sure(0.01), sure(0.01)});
  EXPECT_GT(held.worst, 4.7) << "it contradicts";
}

constexpr double kStep = 0.1, kSigma = 0.03;
constexpr TimeNs kInterval = 200'000'000;

// 20 m ahead at half a metre a second; in site it is turned and moved by `site`.
MapInput drive_with_fixes(const PlanarPose& begin, const PlanarPose& site, bool geodetic,
                          unsigned seed) {
  Noise normal(seed);
  MapInput input;
  input.scale_sigma = 0.01;
  for (int i = 0; i < 200; ++i) {
    PathState state;
    state.time = from_seconds(1e9) + i * kInterval;
    state.pose = compose(begin, {{kStep * i, 0.0}, 0.0});
    state.covariance = 1e-6 * i * Matrix3d::Identity();
    state.pose_covariance = state.covariance;
    input.states.push_back(state);
    if (i % 5 != 4) continue;
    PositionFix fix;
    fix.time = state.time;
    const Vector2d p = compose(site, state.pose).p;
    fix.position << p.x() + normal(kSigma), p.y() + normal(kSigma), 7.0;
    if (geodetic) {
      fix.frame = FixFrame::kGeodetic;
      fix.position = Datum({52.0, 13.0, 0.0}).to_geodetic(fix.position);
    }
    fix.covariance = kSigma * kSigma * Matrix3d::Identity();
    fix.quality = FixQuality::kFixed;
    input.fixes.push_back(fix);
  }
  return input;
}

// In jobs of two seconds, as a path knows its recent states alone. Returns what they said,
// together.
MapAnswer run(Mapper& mapper, const MapInput& all) {
  MapAnswer together;
  auto fix = all.fixes.begin();
  auto trace = all.traces.begin();
  for (std::size_t begin = 0; begin < all.states.size(); begin += 10) {
    MapInput input;
    input.scale_sigma = all.scale_sigma;
    for (std::size_t i = begin; i < std::min(begin + 10, all.states.size()); ++i)
      input.states.push_back(all.states[i]);
    for (; fix != all.fixes.end() && fix->time <= input.states.back().time; ++fix)
      input.fixes.push_back(*fix);
    for (; trace != all.traces.end() && trace->time <= input.states.back().time; ++trace)
      input.traces.push_back(*trace);
    const MapAnswer answer = mapper.run(input);
    together.tied |= answer.tied;
    together.notes.insert(together.notes.end(), answer.notes.begin(), answer.notes.end());
    if (answer.pose) together.pose = answer.pose;
  }
  return together;
}

Config with_datum() {
  Config config = default_config();
  config.anchor.antennas[0] = Vector3d(0.0, 0.0, 0.5);
  config.anchor.datum = Geodetic(52.0, 13.0, 0.0);
  return config;
}

TEST(MapDatum, ATiedDriveLeavesIt) {
  Mapper mapper(with_datum(), std::nullopt, std::nullopt);
  const PlanarPose site{{200.0, 50.0}, 1.0};
  ASSERT_TRUE(run(mapper, drive_with_fixes({}, site, true, 1)).tied);
  const GroundMap ground = mapper.take_ground();
  ASSERT_EQ(ground.datums.size(), 1U);
  const MapDatum& datum = ground.datums.begin()->second;
  EXPECT_TRUE(datum.pose.p.isZero());
  EXPECT_EQ(datum.origin, Geodetic(52.0, 13.0, 0.0));
  EXPECT_NEAR(datum.z, 6.5, 0.05) << "of the body";
  const Matrix3d middle =
      carried(planar_block(datum.covariance), compose(site, {{10.0, 0.0}, 0.0}).p);
  EXPECT_LT(std::sqrt(middle(0, 0)), 0.1);
  EXPECT_GT(std::sqrt(middle(0, 0)), 0.01);
  EXPECT_LT(std::sqrt(middle(2, 2)), 0.02);
}

TEST(MapDatum, WithoutFixesThereIsNone) {
  Mapper mapper(with_datum(), std::nullopt, std::nullopt);
  MapInput input = drive_with_fixes({}, {}, false, 1);
  input.fixes.clear();
  run(mapper, input);
  EXPECT_TRUE(mapper.take_ground().datums.empty());
}

// Earlier ground that lies along x at y = 1, known in site to `sigma`; the track goes on on it.
GroundMap known_ground(double sigma) {
  GroundMap ground{gpr::TraceMemoryOptions()};
  drive(ground, 3, 1.0, 8.0);
  ground.datums[0].covariance = Eigen::Vector4d(sigma, sigma, 1.0, 0.001).cwiseAbs2().asDiagonal();
  return ground;
}

struct Resumed {
  MapAnswer answer;
  GroundMap ground;
};

TrackStart start_on_it() {
  TrackStart start;
  start.map = 0;
  start.map_from_track = {{3.0, 1.0}, 0.0};
  start.covariance = Vector3d(1e-4, 1e-4, 1e-6).asDiagonal();
  return start;
}

Resumed resume(double sigma, const PlanarPose& site) {
  Mapper mapper(with_datum(), known_ground(sigma), start_on_it());
  MapInput input = drive_with_fixes({}, compose(site, {{3.0, 1.0}, 0.0}), false, 2);
  MapAnswer answer = run(mapper, input);
  return {answer, mapper.take_ground()};
}

TEST(MapDatum, ATieGoesOnFromTheStoredOne) {
  const Resumed same = resume(0.05, {});
  EXPECT_TRUE(same.answer.tied);
  EXPECT_TRUE(same.answer.notes.empty());
  ASSERT_EQ(same.ground.datums.count(0), 1U);
  const GroundMap before = known_ground(0.05);
  EXPECT_LT((same.ground.places[0].pose.p - before.places[0].pose.p).norm(), 0.05);
  const Eigen::Matrix4d& covariance = same.ground.datums.at(0).covariance;
  EXPECT_LT(covariance(0, 0), 0.05 * 0.05);
  EXPECT_GT(covariance(0, 0), 1e-5);
  ASSERT_TRUE(same.answer.pose);
  EXPECT_NEAR(same.answer.pose->in_map.pose.p.x(), 3.0 + 199 * kStep, 0.15);
}

// Ground that fixes move lies elsewhere than in its file: what is new is no addition to that.
TEST(MapDatum, GroundThatWasMovedIsSavedAsAWhole) {
  for (const bool fixed : {false, true}) {
    GroundMap ground = known_ground(1.0);
    ground.identity = 5;
    Mapper mapper(with_datum(), std::move(ground), start_on_it());
    MapInput input = drive_with_fixes({}, {{3.0, 1.8}, 0.0}, false, 2);
    if (!fixed) input.fixes.clear();
    const gpr::SyntheticGround there(7, 40.0);
    gpr::SyntheticRadar radar(2, 60.0);
    for (double x = 0.0; x < 19.0; x += 0.02)
      input.traces.push_back(radar.measure(there, x, 1e9 + 0.2 * x / kStep));
    EXPECT_EQ(run(mapper, input).tied, fixed);
    const SavedGround saved = mapper.newest_ground();
    ASSERT_FALSE(saved.bytes.empty());
    EXPECT_EQ(saved.base, fixed ? 0U : 5U);
  }
}

// What was known to a metre gives way to fixes; the ground goes with them.
TEST(MapDatum, AnUncertainOneIsCorrected) {
  const Resumed off = resume(1.0, {{0.0, 0.8}, 0.0});
  EXPECT_TRUE(off.answer.tied);
  const GroundMap before = known_ground(1.0);
  const Vector2d moved = off.ground.places[0].pose.p - before.places[0].pose.p;
  EXPECT_LT((moved - Vector2d(0.0, 0.8)).norm(), 0.15);
}

TEST(MapDatum, AContradictionIsToldAndTheGroundGoesWithTheFixes) {
  const PlanarPose elsewhere{{40.0, -30.0}, 1.2};
  const Resumed moved = resume(0.05, elsewhere);
  EXPECT_TRUE(moved.answer.tied);
  ASSERT_EQ(moved.answer.notes.size(), 1U);
  EXPECT_NE(moved.answer.notes[0].find("contradict"), std::string::npos);
  const GroundMap before = known_ground(0.05);
  EXPECT_LT((moved.ground.places[0].pose.p - compose(elsewhere, before.places[0].pose).p).norm(),
            0.3);
}

}  // namespace
}  // namespace gprodom
