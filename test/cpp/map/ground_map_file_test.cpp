#include "map/ground_map_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <optional>

#include "base/sealed_bytes.h"
#include "driven_ground.h"
#include "gpr/revisit/revisit.h"
#include "gprodom/error.h"

namespace gprodom {
namespace {

using gpr::Columns;
using gpr::MemoryRange;

GroundMap driven(double metres) {
  GroundMap ground{gpr::TraceMemoryOptions()};
  drive(ground, 3, 1.0, 1.0 + metres);
  return ground;
}

GroundMap read(const std::string& bytes) {
  return ground_map_from("a.map", bytes, gpr::TraceMemoryOptions());
}

std::string written(const GroundMap& ground) { return to_bytes(ground, ground.places); }

double correlation(const Columns& a, const Columns& b) {
  return a.cwiseProduct(b).sum() / std::sqrt(a.squaredNorm() * b.squaredNorm());
}

TEST(GroundMapFile, RoundTripKeepsAllOfIt) {
  GroundMap ground = driven(6.0);
  drive(ground, 3, 8.0, 12.0, 2);
  ground.parents = {7, 9};
  ground.descent = {{7, 0}, {11, 123456789}};
  const std::string bytes = written(ground);
  const GroundMap back = read(bytes);
  EXPECT_EQ(written(back), bytes);
  EXPECT_EQ(back.version, 4);
  EXPECT_EQ(back.parents, ground.parents);
  ASSERT_EQ(back.descent.size(), 2U);
  EXPECT_EQ(back.descent[1].mark, 11U);
  EXPECT_EQ(back.descent[1].until, 123456789);
  EXPECT_NE(back.identity, 0U);
  ASSERT_EQ(back.origins.size(), 2U);
  EXPECT_EQ(back.origins[1].program, "test");
  EXPECT_EQ(back.origins[1].robot, "mole");
  EXPECT_EQ(back.origins[1].errors.position, 0.004);
  EXPECT_EQ(back.origins[1].errors.yaw, 0.002);
  EXPECT_EQ(back.origins[1].errors.scale, 0.005);
  EXPECT_EQ(back.origins[1].antenna, Eigen::Vector3d(0.1, 0.0, 0.2));
  ASSERT_EQ(back.memory.kept().size(), ground.memory.kept().size());
  for (const MemoryRange& run : ground.runs()) {
    const gpr::MemoryColumn a = ground.memory.column(run.end - 1);
    const gpr::MemoryColumn b = back.memory.column(run.end - 1);
    EXPECT_EQ(a.time, b.time);
    EXPECT_NEAR(a.distance_m, b.distance_m, 1e-9);
    EXPECT_EQ(ground.memory.session_of(run.first), back.memory.session_of(run.first));
  }
}

// The short map costs no more a metre than a long one: nothing that was learnt is in it.
TEST(GroundMapFile, AtMostSixKilobytesPerMetre) {
  for (const double metres : {4.5, 30.0}) {
    const GroundMap ground = driven(metres);
    const double stored = stored_m(ground.memory);
    ASSERT_GT(stored, metres - 0.5);
    EXPECT_LT(static_cast<double>(written(ground).size()), 6000.0 * stored);
  }
}

// What the file keeps is before gain and whitening: the columns of a radar with a third of the gain
// are a third, and the features learnt from them are the same.
TEST(GroundMapFile, GainAndPulseAreNotInTheColumns) {
  GroundMap ground{gpr::TraceMemoryOptions()}, quiet{gpr::TraceMemoryOptions()};
  drive(ground, 3, 1.0, 9.0);
  gpr::SyntheticRadar radar(1, 60.0, 1.0 / 3.0);
  drive_over(quiet.memory, gpr::SyntheticGround(3, 40.0), radar, 1.0, 9.0, 1e6);
  quiet.memory.end_run();
  const Eigen::RowVectorXf ratio =
      quiet.memory.sessions()[0].deviation.array() / ground.memory.sessions()[0].deviation.array();
  EXPECT_NEAR(ratio.minCoeff(), 1.0 / 3.0, 0.02);
  EXPECT_NEAR(ratio.maxCoeff(), 1.0 / 3.0, 0.02);
}

// Of patches of the ground from column `end` on, with a change undone, those that are found on the
// ground before it, and not farther off than `within_m`.
struct Found {
  int patches = 0, right = 0;
};
Found found_again(const GroundMap& ground, std::size_t end,
                  const std::optional<gpr::TraceChange>& change, double within_m) {
  const gpr::TraceMemory& memory = ground.memory;
  gpr::PatchMatcher matcher(*memory.filter(), memory.spacing());
  const Columns before = memory.patch({0, end});
  const double middle = 0.5 * static_cast<double>(end - 1) * memory.spacing();
  Found found;
  for (std::size_t first = end; first + 92 < memory.kept().end; first += 40, ++found.patches) {
    const MemoryRange range{first, first + 92};
    const Columns query = change ? memory.patch(range, *change) : memory.patch(range);
    const double there = memory.column(first).distance_m + 45.5 * memory.spacing() -
                         memory.column(0).distance_m - middle;
    const gpr::RevisitMatch match = matcher.match(before, query, there - 0.2, 0.6);
    found.right += match.accepted && std::abs(match.offset_m - there) < within_m ? 1 : 0;
  }
  return found;
}

// Features learnt anew on loading tell the place as those learnt while driving did.
TEST(GroundMapFile, GroundIsFoundAgainAfterLoading) {
  GroundMap ground = read(written(driven(12.0)));
  const std::size_t end = ground.memory.kept().end;
  drive(ground, 3, 4.0, 9.0, 5);
  EXPECT_EQ(ground.memory.sessions().size(), 2U);
  const Found found = found_again(ground, end, std::nullopt, 0.015);
  ASSERT_GT(found.patches, 2);
  EXPECT_EQ(found.right, found.patches);
}

// Features are made a block of columns at a time.
TEST(GroundMapFile, FeaturesOfALongRunAreThoseOfAllItsColumnsAtOnce) {
  GroundMap ground{gpr::TraceMemoryOptions()};
  drive(ground, 1, 0.0, 35.0);
  const GroundMap loaded = reloaded(ground);
  const gpr::MemoryRange run = loaded.runs().front();
  ASSERT_GT(run.size(), 1500);
  const gpr::TraceChange hardly{1e-12, 0.0};
  constexpr float kLevel = 1.0F / gpr::TraceMemory::kLevelsPerUnit, kMost = 127 * kLevel;
  const gpr::Columns at_once = loaded.memory.patch(run, hardly).cwiseMin(kMost).cwiseMax(-kMost);
  EXPECT_LE((loaded.memory.patch(run) - at_once).cwiseAbs().maxCoeff(), 0.6F * kLevel);
}

// Waves are slower by 8 % on another day: only with travel times stretched is the place found.
TEST(GroundMapFile, ChangedGroundIsFoundByItsStretch) {
  GroundMap ground = read(written(driven(12.0)));
  const std::size_t end = ground.memory.kept().end;
  ASSERT_TRUE(ground.memory.can_undo());
  drive(ground, 3, 4.0, 9.0, 5, 1e8 / 1.08);
  const Found stretched = found_again(ground, end, gpr::TraceChange{std::log(1.08), 0.0}, 0.03);
  EXPECT_EQ(stretched.right, stretched.patches);
  const Found as_it_is = found_again(ground, end, gpr::TraceChange{0.0, 0.0}, 0.03);
  EXPECT_LT(as_it_is.right, as_it_is.patches / 2);
}

TEST(GroundMapFile, VersionOneIsReadAndStaysSo) {
  const GroundMap old = driven(6.0).features_alone();
  const std::string bytes = written(old);
  EXPECT_EQ(bytes.substr(0, 21), "gprodom ground map 1\n");
  GroundMap back = read(bytes);
  EXPECT_EQ(back.version, 1);
  EXPECT_EQ(written(back), bytes);
  const MemoryRange kept = back.memory.kept();
  EXPECT_GT(correlation(back.memory.patch(kept), old.memory.patch(kept)), 0.999);
  drive(back, 3, 8.0, 12.0, 2);  // it goes on, and as version 1
  EXPECT_TRUE(back.memory.sessions().empty());
  EXPECT_GT(back.memory.kept().size(), kept.size() + 150);
  EXPECT_EQ(written(back).substr(0, 21), "gprodom ground map 1\n");
  EXPECT_EQ(back.part({{10, 200}}).version, 1);
}

constexpr std::size_t kSeal = 21 + 16, kDescent = 24 + 4;  // of ground without parents

// The same bytes without what the ground comes from.
std::string as_version_3(const std::string& bytes) {
  std::string body = bytes.substr(kSeal);
  std::uint32_t ancestors = 0;
  std::memcpy(&ancestors, body.data() + kDescent, sizeof ancestors);
  body.erase(kDescent, sizeof ancestors + ancestors * 16);
  ByteWriter out;
  out.put_all(body.data(), body.size());
  return out.sealed("gprodom ground map 3");
}

// The same without a session's robot and the errors of its path.
std::string as_version_2(const std::string& bytes) {
  constexpr std::size_t kAntenna = kDescent + 1 + 4 + 4;
  std::string body = as_version_3(bytes).substr(kSeal);
  const std::size_t robot = kAntenna + 24 + 4 + std::string("test").size();
  body.erase(robot, 4 + std::string("mole").size() + 3 * sizeof(double));
  ByteWriter out;
  out.put_all(body.data(), body.size());
  return out.sealed("gprodom ground map 2");
}

TEST(GroundMapFile, VersionThreeIsReadAndItsGroundGoesOnFromIt) {
  GroundMap ground = driven(6.0);
  ground.extended(0, 7, true);
  const std::string old = as_version_3(written(ground));
  GroundMap back = read(old);
  EXPECT_EQ(back.version, 3);
  EXPECT_TRUE(back.descent.empty());
  EXPECT_TRUE(back.goes_on_from(ground_head("a.map", old).identity));
  const std::size_t end = back.memory.kept().end;
  drive(back, 3, 8.0, 12.0, 2);
  EXPECT_FALSE(descends(ground_head("a.map", written(back)), ground_head("b.map", old)));
  back.extended(end, 9, true);
  EXPECT_TRUE(descends(ground_head("a.map", written(back)), ground_head("b.map", old)));
  EXPECT_EQ(read(written(back)).version, 4);
}

TEST(GroundMapFile, VersionTwoIsReadAsOfAnUnknownRobot) {
  const GroundMap ground = driven(6.0);
  const GroundMap back = read(as_version_2(written(ground)));
  EXPECT_EQ(back.version, 2);
  ASSERT_EQ(back.origins.size(), 1U);
  EXPECT_EQ(back.origins[0].program, "test");
  EXPECT_EQ(back.origins[0].robot, "");
  EXPECT_EQ(back.origins[0].errors.yaw, PathErrors().yaw);
  EXPECT_EQ(back.memory.stored_run(back.memory.kept()).levels,
            ground.memory.stored_run(ground.memory.kept()).levels);
  EXPECT_EQ(back.places.size(), ground.places.size());
  EXPECT_EQ(read(written(back)).version, 4);
}

MapDatum datum() {
  MapDatum datum;
  datum.pose = {{120.0, -40.0}, 0.3};
  datum.z = 5.0;
  datum.covariance = Eigen::Vector4d(0.01, 0.02, 0.5, 1e-5).asDiagonal();
  datum.covariance(0, 3) = datum.covariance(3, 0) = 1e-4;
  datum.origin = Geodetic(52.39, 13.06, 40.0);
  return datum;
}

// What is in no site has the bytes that it had before there were datums.
TEST(GroundMapFile, ADatumIsKeptAndIsAllThatMakesItVersionFive) {
  GroundMap ground = driven(6.0);
  const std::string without = written(ground);
  EXPECT_EQ(without.substr(0, kSeal - 16), "gprodom ground map 4\n");
  ground.datums[3] = datum();
  EXPECT_EQ(written(ground), without) << "of a map that is not in the file";
  ground.datums[0] = datum();
  const std::string bytes = written(ground);
  EXPECT_EQ(bytes.substr(0, kSeal - 16), "gprodom ground map 5\n");
  EXPECT_EQ(bytes.substr(kSeal, without.size() - kSeal), without.substr(kSeal));
  const GroundMap back = read(bytes);
  EXPECT_EQ(back.version, 5);
  EXPECT_EQ(written(back), bytes);
  ASSERT_EQ(back.datums.size(), 1U);
  const MapDatum& found = back.datums.at(0);
  EXPECT_EQ(found.pose.p, datum().pose.p);
  EXPECT_EQ(found.pose.yaw, 0.3);
  EXPECT_EQ(found.z, 5.0);
  EXPECT_EQ(found.covariance, datum().covariance);
  EXPECT_EQ(found.origin, datum().origin);
  EXPECT_EQ(back.part({{20, 200}}).datums.size(), 1U);
}

TEST(GroundMapFile, AnAntennaIsKeptAndItsIdMakesItVersionSix) {
  GroundMap ground = driven(6.0);
  const std::string without = written(ground);
  ground.origins[0].antenna_id = 7;
  const std::string bytes = written(ground);
  EXPECT_EQ(bytes.substr(0, kSeal - 16), "gprodom ground map 6\n");
  const GroundMap back = read(bytes);
  EXPECT_EQ(back.version, 6);
  EXPECT_EQ(back.origins[0].antenna_id, 7);
  EXPECT_EQ(back.origins[0].antenna, ground.origins[0].antenna);
  EXPECT_EQ(written(back), bytes);
  EXPECT_EQ(read(without).origins[0].antenna_id, 0);
}

TEST(GroundMapFile, ADatumThatMakesNoSenseIsRefused) {
  const auto refused = [](const std::function<void(MapDatum&)>& spoil) {
    GroundMap ground = driven(4.5);
    ground.datums[0] = datum();
    spoil(ground.datums[0]);
    EXPECT_THROW(read(written(ground)), FileError);
  };
  refused([](MapDatum& d) { d.pose.yaw = NAN; });
  refused([](MapDatum& d) { d.z = HUGE_VAL; });
  refused([](MapDatum& d) { d.covariance(1, 1) = -1.0; });
  refused([](MapDatum& d) { d.covariance(0, 1) = 1e-3; });
  refused([](MapDatum& d) { d.origin->x() = 91.0; });
  refused([](MapDatum& d) { d.origin->y() = NAN; });
}

TEST(GroundMapFile, PartHoldsItsSessionsAlone) {
  GroundMap ground = driven(6.0);
  drive(ground, 3, 8.0, 12.0, 2);
  const GroundMap whole = read(written(ground));
  const MemoryRange second = whole.runs().back();
  const GroundMap part = whole.part({{second.first + 20, second.end}});
  EXPECT_EQ(part.memory.sessions().size(), 1U);
  EXPECT_EQ(part.origins.size(), 1U);
  EXPECT_EQ(part.parents, std::vector<std::uint64_t>{whole.identity});
  EXPECT_EQ(part.memory.stored_run(part.memory.kept()).levels,
            whole.memory.stored_run({second.first + 20, second.end}).levels);
  EXPECT_EQ(whole.part({{0, 5}}).memory.kept().size(), 5U);  // too short to learn from
}

TEST(GroundMapFile, DamagedFilesAreRefused) {
  const std::string bytes = written(driven(5.0));
  for (std::size_t at = 0; at < bytes.size(); at += 1 + at / 50) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    EXPECT_THROW(read(damaged), FileError) << at;
    EXPECT_THROW(read(bytes.substr(0, at)), FileError) << at;
  }
  EXPECT_THROW(read(bytes + '\0'), FileError);
}

}  // namespace
}  // namespace gprodom
