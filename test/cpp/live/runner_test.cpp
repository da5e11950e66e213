#include "live/runner.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "pipeline/test_drive.h"
#include "support/temporary_folder.h"
#include "support/told.h"

namespace gprodom {
namespace {

namespace fs = std::filesystem;

class RunnerTest : public ::testing::Test {
 protected:
  RunnerTest() { fs::create_directory(folder_ / "state"); }

  // Everything that is told when a robot that stands gets these commands after its first message.
  std::vector<std::string> told(const std::vector<std::string>& settings,
                                const std::vector<Command>& commands) {
    Runner runner(default_config(settings), Execution::kInline);
    Outputs all;
    std::vector<Input> inputs = standing(0.1);
    inputs.insert(inputs.begin() + 1, commands.begin(), commands.end());
    for (const Input& input : inputs) append(all, runner.feed(input));
    append(all, runner.finish());
    return all.warnings;
  }
  static bool has(const std::vector<std::string>& told, const std::string& part) {
    return count_with(told, part) > 0;
  }

  TemporaryFolder folder_;
  std::string kept_ = "state.directory=" + (folder_ / "state");
};

TEST_F(RunnerTest, EveryCommandNameIsKnownAndAnotherIsRefusedWithThem) {
  const std::string unknown = "unknown command, expected reset, save_map, load_map or locate_at";
  for (const char* name : names_like(CommandName{}))
    EXPECT_FALSE(has(told({}, {{0, name, ""}}), unknown)) << name;
  EXPECT_TRUE(has(told({}, {{0, "rset", ""}}), unknown));
}

TEST_F(RunnerTest, ResetReportsWhetherTheGroundIsKept) {
  const std::string reset = name_of(CommandName::kReset);
  EXPECT_TRUE(has(told({}, {{0, reset, ""}}), "the ground is kept"));
  EXPECT_TRUE(has(told({}, {{0, reset, kResetAll}}), "all is forgotten"));
}

TEST_F(RunnerTest, ResetWithAnUnknownArgumentIsRefused) {
  const auto all = told({}, {{0, name_of(CommandName::kReset), "bogus"}});
  EXPECT_TRUE(has(all, "COMMAND: reset: expected no argument, or all"));
  EXPECT_FALSE(has(all, "reset by command"));
}

TEST_F(RunnerTest, MapCommandsUseTheStateFolder) {
  const std::string longest(100, 'n');
  for (const std::string& name : {std::string("Yard-2.north_1"), longest}) {
    const auto all = told({kept_}, {{0, "save_map", name}, {0, "load_map", name}});
    EXPECT_TRUE(has(all, name + ".map: saved"));
    EXPECT_TRUE(has(all, "map " + name + " loaded"));
    EXPECT_TRUE(fs::exists(folder_ / ("state/" + name + ".map")));
  }
}

TEST_F(RunnerTest, MapNameCannotReachOtherFolders) {
  const std::string here = folder_ / "here";
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string(".hidden"),
        std::string("../outside"), std::string("below/it"), here, std::string("a b"),
        std::string("a\n"), std::string("a\0b", 3), std::string("\xc3\xa4"),
        std::string(101, 'n')}) {
    for (const char* command : {"save_map", "load_map"}) {
      const auto all = told({kept_}, {{0, command, name}});
      EXPECT_TRUE(has(all, std::string("COMMAND: ") + command + ": expected a map's name"))
          << command << " " << name;
    }
  }
  EXPECT_EQ(folder_.files(), std::set<std::string>{"state/lock"});  // what each run leaves
}

TEST_F(RunnerTest, LocateAtWantsFourFiguresAndPerhapsAMap) {
  for (const char* bad : {"", "1 2 3", "1 2 3 x", "1 2 3 0.5 x", "1 2 3 0.5 -1", "1 2 3 0.5 0 9",
                          "1,2,3,0.5", "1 2 3 0", "1 2 3 -1", "1 2 3 5", "nan 2 3 0.5"}) {
    EXPECT_TRUE(has(told({}, {{0, "locate_at", bad}}), "COMMAND: locate_at: expected ")) << bad;
  }
  for (const char* good : {"1 2 3 0.5", " -1.5e1 2 -3.1 0.5 0 "})
    EXPECT_FALSE(has(told({}, {{0, "locate_at", good}}), "locate_at: expected")) << good;
}

TEST_F(RunnerTest, ReadOnlySavesNoMap) {
  EXPECT_TRUE(has(told({kept_, "state.map=read_only"}, {{0, "save_map", "yard"}}),
                  "state.map is read_only"));
  EXPECT_FALSE(fs::exists(folder_ / "state/ground.map"));
}

TEST_F(RunnerTest, MapCommandsAreRefusedWithoutAStateFolder) {
  for (const char* command : {"save_map", "load_map"})
    EXPECT_TRUE(has(told({}, {{0, command, "yard"}}), "state.directory is empty"));
}

TEST_F(RunnerTest, MissingMapIsReported) {
  EXPECT_TRUE(has(told({kept_}, {{0, "load_map", "yard"}}), "yard.map: no such file"));
}

// Without a map nothing can be saved, and that is said: who asked must not wait for ever.
TEST_F(RunnerTest, MapCommandsAreRefusedWithoutAMap) {
  for (const char* off : {"graph.enabled=false", "gpr.enabled=false"}) {
    for (const char* command : {"save_map", "load_map"}) {
      const auto all = told({kept_, off}, {{0, command, "yard"}});
      EXPECT_TRUE(has(all, std::string("COMMAND: ") + command + ": ")) << command << " " << off;
      EXPECT_TRUE(has(all, "graph.enabled")) << command << " " << off;
    }
  }
  EXPECT_EQ(folder_.files(), std::set<std::string>{"state/lock"});
}

}  // namespace
}  // namespace gprodom
