#include "map/ground_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <utility>
#include <vector>

#include "base/atomic_file.h"
#include "driven_ground.h"
#include "gprodom/error.h"
#include "support/temporary_folder.h"

namespace gprodom {
namespace {

namespace fs = std::filesystem;

// Ground of a drive as a mapper would have it: with its mark.
GroundMap driven(unsigned seed, double metres, unsigned noise = 1) {
  GroundMap ground{gpr::TraceMemoryOptions()};
  drive(ground, seed, 1.0, 1.0 + metres, noise);
  ground.extended(0, ground.memory.column(ground.memory.kept().end - 1).time, true);
  return ground;
}

// The same ground driven on: another drive at other times.
void drive_on(GroundMap& ground, unsigned noise) {
  const std::size_t first = ground.memory.kept().end;
  drive(ground, 3, 20.0, 26.0, noise);
  ground.extended(first, ground.memory.column(ground.memory.kept().end - 1).time, true);
}

SavedGround saved(const GroundMap& ground) {
  return {to_bytes(ground, ground.places), ground.descent, !ground.memory.filter(), 0};
}

class GroundFilesTest : public ::testing::Test {
 protected:
  std::string path() const { return folder_ / "ground.map"; }
  std::string kept(int number) const {
    return folder_ / ("ground.kept-" + std::to_string(number) + ".map");
  }
  std::set<std::string> names() const { return folder_.files(); }

  bool replaced(const SavedGround& ground) { return files_.replace(path(), ground, told_); }
  std::vector<std::string> take_told() { return std::exchange(told_, {}); }

  TemporaryFolder folder_;
  GroundFiles files_;
  std::vector<std::string> told_;
};

TEST_F(GroundFilesTest, GroundThatGrowsReplacesItsFile) {
  GroundMap ground = driven(3, 6.0);
  std::vector<std::string> notices;
  EXPECT_TRUE(replaced(saved(ground)));
  for (unsigned noise = 2; noise < 5; ++noise) {
    drive_on(ground, noise);
    EXPECT_TRUE(replaced(saved(ground)));
    GroundFiles others;  // of another run, which reads what is there
    ground = *read_ground_map(path(), gpr::TraceMemoryOptions(), notices);
    drive_on(ground, noise + 10);
    EXPECT_TRUE(others.replace(path(), saved(ground), told_));
  }
  EXPECT_EQ(names(), std::set<std::string>{"ground.map"});
  EXPECT_TRUE(take_told().empty());
}

TEST_F(GroundFilesTest, OtherGroundSetsTheFileAsideOnce) {
  const SavedGround before = saved(driven(3, 6.0));
  replaced(before);
  GroundMap other = driven(4, 6.0);
  replaced(saved(other));
  EXPECT_EQ(bytes_of(kept(1)), before.bytes);
  ASSERT_EQ(take_told().size(), 1U);
  for (unsigned noise = 2; noise < 5; ++noise) {
    drive_on(other, noise);
    replaced(saved(other));
  }
  EXPECT_EQ(names(), (std::set<std::string>{"ground.map", "ground.kept-1.map"}));
  EXPECT_EQ(bytes_of(kept(1)), before.bytes);
  EXPECT_TRUE(take_told().empty());
}

// Ground that was taken up from an older state of the same file lacks what was driven since.
TEST_F(GroundFilesTest, AnOlderStateOfTheSameGroundDoesNotReplaceTheNewer) {
  GroundMap ground = driven(3, 6.0);
  GroundMap older = ground;
  drive_on(ground, 2);
  replaced(saved(ground));
  const std::string newer = bytes_of(path());
  replaced(saved(older));
  EXPECT_EQ(bytes_of(kept(1)), newer);
  drive_on(older, 7);
  replaced(saved(older));
  EXPECT_EQ(names(), (std::set<std::string>{"ground.map", "ground.kept-1.map"}));
}

TEST_F(GroundFilesTest, AMapFromWhichSomeWasCutDoesNotReplaceTheWhole) {
  GroundMap ground = driven(3, 8.0);
  replaced(saved(ground));
  std::vector<std::string> notices;
  const GroundMap whole = *read_ground_map(path(), gpr::TraceMemoryOptions(), notices);
  replaced(saved(whole.part({{0, 200}})));
  EXPECT_TRUE(fs::exists(kept(1)));
}

TEST_F(GroundFilesTest, GroundOfWhichNothingIsStoredReplacesNothing) {
  const SavedGround empty = saved(GroundMap(gpr::TraceMemoryOptions()));
  EXPECT_TRUE(replaced(empty));  // there is none yet
  const SavedGround ground = saved(driven(3, 6.0));
  EXPECT_TRUE(replaced(ground));
  EXPECT_FALSE(replaced(empty));
  EXPECT_EQ(bytes_of(path()), ground.bytes);
  EXPECT_EQ(names(), std::set<std::string>{"ground.map"});
}

TEST_F(GroundFilesTest, AFileThatCannotBeUsedIsNotOverwritten) {
  const SavedGround ground = saved(driven(3, 6.0));
  const SavedGround empty = saved(GroundMap(gpr::TraceMemoryOptions()));
  std::string changed = ground.bytes;
  changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] ^ 1);
  int number = 0;
  for (const std::string& damaged : {std::string(), ground.bytes.substr(0, 5000), changed,
                                     std::string("gprodom ground map 99\nof a later program")}) {
    std::ofstream(path(), std::ios::binary) << damaged;
    files_ = GroundFiles();  // the next run
    EXPECT_FALSE(replaced(empty));
    EXPECT_EQ(bytes_of(path()), damaged);
    EXPECT_TRUE(replaced(ground));
    EXPECT_EQ(bytes_of(kept(++number)), damaged);
    EXPECT_EQ(bytes_of(path()), ground.bytes);
    EXPECT_EQ(take_told().size(), 1U);
  }
}

// Version 1 does not say where its ground comes from. Of what it has written itself, this knows.
TEST_F(GroundFilesTest, GroundOfVersionOneGrows) {
  GroundMap ground = driven(3, 6.0).features_alone();
  replaced(saved(ground));
  std::vector<std::string> notices;
  ground = *read_ground_map(path(), gpr::TraceMemoryOptions(), notices);
  for (unsigned noise = 2; noise < 4; ++noise) {
    drive_on(ground, noise);
    replaced(saved(ground));
  }
  EXPECT_EQ(names(), std::set<std::string>{"ground.map"});
}

// The whole file of some of a drive and, beside it, what is new are the ground of all of it.
TEST_F(GroundFilesTest, NewestGroundIsReadWithTheFileThatItBelongsTo) {
  GroundMap ground = driven(3, 6.0);
  drive(ground, 3, 20.0, 24.0, 2, 1e8, true);
  ground.extended(0, 5, true);
  const SavedGround whole = saved(ground);
  replaced(whole);
  const SavedColumns columns{ground_head("", whole.bytes).identity, 0, ground.memory.kept().end};
  ASSERT_GT(ground.memory.kept().end, 400U);
  const std::size_t first_of_drive = ground.memory.run_of(ground.memory.kept().end - 1).first;
  // It goes on driving: the run that was under way grows, and others follow.
  gpr::SyntheticRadar radar(9, 60.0);
  drive_over(ground.memory, gpr::SyntheticGround(3, 40.0), radar, 24.0, 30.0, 3e6);
  ground.memory.end_run();
  drive(ground, 3, 30.0, 35.0, 4);
  ground.extended(0, 9, false);
  ground.datums[0].covariance.setIdentity();  // fixes have tied it since,
  ground.origins.back().antenna_id = 1;       // and another antenna has seen it
  SavedGround newest{newest_to_bytes(ground, ground.places, first_of_drive, columns),
                     ground.descent, false, columns.identity};
  EXPECT_LT(newest.bytes.size(), 0.7 * static_cast<double>(to_bytes(ground, ground.places).size()));
  EXPECT_TRUE(files_.add_newest(path(), newest, told_));
  std::vector<std::string> notices;
  const GroundMap read = *read_ground_map(path(), gpr::TraceMemoryOptions(), notices);
  EXPECT_TRUE(notices.empty());
  EXPECT_TRUE(to_bytes(read, read.places) == to_bytes(ground, ground.places));

  // One that belongs to another file is left alone, and one that is damaged is left out.
  newest.base += 1;
  EXPECT_FALSE(files_.add_newest(path(), newest, told_));
  std::ofstream(newest_of(path()), std::ios::binary | std::ios::app) << "x";
  const GroundMap without = *read_ground_map(path(), gpr::TraceMemoryOptions(), notices);
  EXPECT_EQ(notices.size(), 1U);
  EXPECT_TRUE(to_bytes(without, without.places) == whole.bytes);
  // Ground that cannot be read is kept, as some may still be got out of it, and told.
  newest.base -= 1;
  const std::string damaged = bytes_of(newest_of(path()));
  EXPECT_TRUE(files_.add_newest(path(), newest, told_));
  EXPECT_EQ(names(), (std::set<std::string>{"ground.kept-1.new", "ground.map", "ground.new"}));
  EXPECT_TRUE(bytes_of(folder_ / "ground.kept-1.new") == damaged);
  EXPECT_EQ(take_told().size(), 1U);
  replaced(saved(ground));
  EXPECT_EQ(names(), (std::set<std::string>{"ground.kept-1.new", "ground.map"}));
  EXPECT_TRUE(take_told().empty());
}

// What was kept of newest ground does not become that of a map that is set aside later.
TEST_F(GroundFilesTest, DamagedNewestGroundIsKeptAlsoWhenTheWholeFileIsWritten) {
  replaced(saved(driven(3, 6.0)));
  std::ofstream(newest_of(path())) << "damaged";
  GroundMap other = driven(4, 6.0);
  replaced(saved(other));
  EXPECT_EQ(names(),
            (std::set<std::string>{"ground.kept-1.map", "ground.kept-1.new", "ground.map"}));
  std::ofstream(newest_of(path())) << "damaged too";
  drive_on(other, 2);
  take_told();
  replaced(saved(other));
  EXPECT_EQ(bytes_of(folder_ / "ground.kept-2.new"), "damaged too");
  const std::vector<std::string> told = take_told();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("ground.kept-2.new, one of 3 files"), std::string::npos) << told[0];
  EXPECT_FALSE(fs::exists(kept(2)));
}

}  // namespace
}  // namespace gprodom
