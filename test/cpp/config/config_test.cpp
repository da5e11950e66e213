#include "gprodom/config.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <set>
#include <sstream>

#include "config/config_keys.h"
#include "config/config_value.h"
#include "config/former_keys.h"
#include "gprodom/error.h"
#include "support/temporary_folder.h"

namespace gprodom {
namespace {

// A config file of this content; gone with the object.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& content) { std::ofstream(path()) << content; }
  std::string path() const { return folder_ / "config.yaml"; }

 private:
  TemporaryFolder folder_;
};

std::string error_of(const std::function<void()>& load) {
  try {
    load();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

// The error of loading `content`, with the file's path written as FILE.
std::string error_of_file(const std::string& content) {
  const TemporaryFile file(content);
  std::string message = error_of([&] { load_config({file.path()}); });
  const auto start = message.find(file.path());
  if (start != std::string::npos) message.replace(start, file.path().size(), "FILE");
  return message;
}

std::string error_of_override(const std::string& text) {
  return error_of([&] { default_config({text}); });
}

TEST(Config, AntennasByTheirIds) {
  const Config config =
      default_config({"gpr.lever_arm=[9, 9, 9]", "gpr.antennas={3: [0.1, 0, 0], 2: [-0.2, 0, 1]}"});
  ASSERT_EQ(config.gpr.antennas.size(), 2U);
  EXPECT_EQ(config.gpr.antennas.at(3), Eigen::Vector3d(0.1, 0, 0));
  EXPECT_EQ(config.gpr.lever_arm, Eigen::Vector3d(-0.2, 0, 1)) << "that of the first of them";
  EXPECT_EQ(
      error_of_file("gpr:\n  antennas: {0: [1, 2]}\n"),
      "FILE:2: gpr.antennas: expected a map of antenna_id to [x, y, z], each id once (m), got "
      "a map");
}

TEST(Config, TimeOffsetsOfAntennasByTheirIds) {
  EXPECT_TRUE(default_config().gpr.time_offsets.empty());
  const Config config = default_config({"gpr.time_offsets={1: -0.004, 0: 0.25}"});
  EXPECT_EQ(config.gpr.time_offsets, (AntennaOffsets{{0, 0.25}, {1, -0.004}}));
  EXPECT_EQ(
      error_of_file("gpr:\n  time_offsets: {0: 11}\n"),
      "FILE:2: gpr.time_offsets: expected a map of antenna_id to a number, each id once, from "
      "-10 to 10 (s), got a map");
  EXPECT_EQ(error_of_file("gpr:\n  antennas: {0: [0, 0, 0]}\n  time_offsets: {1: 0.1}\n"),
            "FILE: gpr.time_offsets: expected antennas that gpr.antennas has, got 1");
}

TEST(Config, DatumIsThreeNumbersOrNone) {
  EXPECT_FALSE(default_config().anchor.datum);
  const Config config = default_config({"anchor.datum=[47.5, 8.25, 400]"});
  EXPECT_EQ(config.anchor.datum, Eigen::Vector3d(47.5, 8.25, 400));
  EXPECT_FALSE(default_config({"anchor.datum=[1, 2, 3]", "anchor.datum=[]"}).anchor.datum);
  EXPECT_EQ(error_of_file("anchor:\n  datum: [1, 2]\n"),
            "FILE:2: anchor.datum: expected [a, b, c], three numbers, or [] (deg, deg, m), got "
            "[\"1\", \"2\"]");
}

TEST(Config, OverridesWinOverTheFileAndLaterOverridesOverEarlier) {
  const TemporaryFile file(
      "wheel:\n  scale: 1.02   # comment\n  lever_arm: [0.1, -2e-1, +3]\n  enabled: false\n"
      "imu: {lever_arm: [0.5, 0, -0.2]}\n"
      "paper: {rows: 7}\nchannels:\n  imu: 'MY IMU'\ngpr:\n");
  const Config config = load_config(
      {file.path()}, {"wheel.scale=0.97", "paper.wheel_form=distance", "wheel.scale=0.98"});
  EXPECT_DOUBLE_EQ(config.wheel.scale, 0.98);
  EXPECT_EQ(config.wheel.form, WheelForm::kDistance);
  EXPECT_EQ(config.wheel.lever_arm, Eigen::Vector3d(0.1, -0.2, 3.0));
  EXPECT_EQ(config.imu.lever_arm, Eigen::Vector3d(0.5, 0, -0.2));
  EXPECT_FALSE(config.wheel.enabled);
  EXPECT_EQ(config.gpr.sequential.rows, 7);
  EXPECT_EQ(config.channels.imu, "MY IMU");
  EXPECT_DOUBLE_EQ(config.smoother.lag, Config().smoother.lag);
}

// As of `calibrate -o`: each file has the keys that it knows of.
TEST(Config, LaterFilesOverrideEarlierFilesKeyByKey) {
  const TemporaryFile robot("wheel:\n  scale: 1.02\n  noise: 0.01\n  lever_arm: [1, 2, 3]\n");
  const TemporaryFile wheel("wheel:\n  scale: 0.98\n  lever_arm: [0, 0, 4]\n");
  const TemporaryFile time("imu:\n  time_offset: 0.1\n");
  const Config config = load_config({robot.path(), wheel.path(), time.path()});
  EXPECT_DOUBLE_EQ(config.wheel.scale, 0.98);
  EXPECT_DOUBLE_EQ(config.wheel.noise, 0.01);
  EXPECT_EQ(config.wheel.lever_arm, Eigen::Vector3d(0, 0, 4));
  EXPECT_DOUBLE_EQ(config.imu.time_offset, 0.1);
  EXPECT_DOUBLE_EQ(load_config({wheel.path(), robot.path()}).wheel.scale, 1.02);
  EXPECT_DOUBLE_EQ(load_config({robot.path(), wheel.path()}, {"wheel.scale=1"}).wheel.scale, 1.0);
}

// Two files may each be valid and contradict each other.
TEST(Config, ChannelsOfSeveralFilesMustDiffer) {
  const TemporaryFile one("channels:\n  imu: MINE\n"), other("channels:\n  wheel: MINE\n");
  EXPECT_EQ(error_of([&] {
              load_config({one.path(), other.path()});
            }),
            one.path() + ": " + other.path() +
                ": channels.wheel: expected a channel of its own, got \"MINE\", which is "
                "channels.imu");
}

TEST(Config, ErrorsNameFileLineKeyAndExpectation) {
  EXPECT_EQ(error_of_file("wheel:\n  scale: abc\n"),
            "FILE:2: wheel.scale: expected a number from 0.1 to 10, got \"abc\"");
  EXPECT_EQ(error_of_file("wheel:\n\n  noise: 0\n"),
            "FILE:3: wheel.noise: expected a number above 0 (m/sqrt(m)), got \"0\"");
  EXPECT_EQ(error_of_file("wheel: {max_speed: .inf}"),
            "FILE:1: wheel.max_speed: expected a number 0 or more (m/s), got \".inf\"");
  EXPECT_EQ(error_of_file("imu:\n  time_offset: nan\n"),
            "FILE:2: imu.time_offset: expected a number from -10 to 10 (s), got \"nan\"");
  EXPECT_EQ(error_of_file("paper:\n  rows: 2.5\n"),
            "FILE:2: paper.rows: expected an integer from 1 to 500, got \"2.5\"");
  EXPECT_EQ(error_of_file("wheel:\n  enabled: maybe\n"),
            "FILE:2: wheel.enabled: expected true or false, got \"maybe\"");
  EXPECT_EQ(error_of_file("paper:\n  wheel_form: norm\n"),
            "FILE:2: paper.wheel_form: expected one of increment | distance, got \"norm\"");
  EXPECT_EQ(error_of_file("wheel:\n  lever_arm: [1, 2]\n"),
            "FILE:2: wheel.lever_arm: expected [x, y, z], three numbers from -100 to 100 (m), "
            "got [\"1\", \"2\"]");
  EXPECT_EQ(error_of_file("imu:\n  lever_arm: [500, 0, 0]\n"),
            "FILE:2: imu.lever_arm: expected [x, y, z], three numbers from -100 to 100 (m), "
            "got [\"500\", \"0\", \"0\"]");
  EXPECT_EQ(error_of_file("channels:\n  imu:\n"),
            "FILE:2: channels.imu: expected text of at most 63 characters, got nothing");
  EXPECT_EQ(error_of_file("channels:\n  imu: WHEEL\n"),
            "FILE: channels.wheel: expected a channel of its own, got \"WHEEL\", which is "
            "channels.imu");
  EXPECT_EQ(error_of_file("wheel:\n  scale:\n    deeper: 1\n"),
            "FILE:2: wheel.scale: expected a number from 0.1 to 10, got a map");
  EXPECT_EQ(error_of_file("wheel:\n  scale: 1\n  scale: 2\n"),
            "FILE:3: wheel.scale: given twice in this section");
  EXPECT_EQ(error_of_file("wheel: 3\n"), "FILE:1: wheel: expected a map of keys, got \"3\"");
  EXPECT_EQ(error_of_file("- wheel\n"), "FILE:1: expected a map of keys, got [\"wheel\"]");
  EXPECT_EQ(error_of_file("wheel:\n  scale: 1\n---\ngpr:\n").rfind("FILE:3: expected one", 0), 0u);
  EXPECT_EQ(error_of_file("wheel:\n  scale: [1\n").rfind("FILE:3: not YAML: ", 0), 0u);
}

// A wider window makes the estimate worse without any sign of it, so it is refused with a reason.
TEST(Config, ReorderWindowAboveOneSecondIsRefused) {
  EXPECT_EQ(default_config({"time.reorder_window=1"}).time.reorder_window, 1.0);
  EXPECT_EQ(error_of_override("time.reorder_window=1.1"),
            "--set time.reorder_window=1.1: expected a number from 0 to 1 (s), since every state "
            "waits for this time, and poses are predicted over it by the IMU alone, got \"1.1\"");
}

TEST(Config, UnknownKeysAreErrorsWithSuggestion) {
  EXPECT_EQ(error_of_file("wheel:\n  scal: 1\n"),
            "FILE:2: wheel.scal: unknown key; did you mean wheel.scale?");
  EXPECT_EQ(error_of_file("imu:\n  wave_speed: 1e8\n"),
            "FILE:2: imu.wave_speed: unknown key; did you mean gpr.wave_speed?");
  EXPECT_EQ(error_of_file("turbo:\n  boost: 1\n"),
            "FILE:1: turbo: unknown key; config/gprodom.yaml lists all keys");
  EXPECT_EQ(error_of_override("whele.scale=1"),
            "--set whele.scale=1: unknown key; did you mean wheel.scale?");
  EXPECT_EQ(error_of_override("wheel=1"), "--set wheel=1: expected a section of keys below it");
}

// Every setting that is an enum: each of its names is read and written back, any other refused.
TEST(Config, ChoicesAreNamed) {
  int choices = 0;
  Config defaults;
  for (const auto& key : config_keys(defaults)) {
    const std::string names = short_range(key);
    if (names.find(" | ") == std::string::npos) continue;
    ++choices;
    std::istringstream words(names);
    for (std::string name; words >> name;) {
      if (name == "|") continue;
      Config config = default_config({key.name + "=" + name});
      for (const auto& set : config_keys(config)) {
        if (set.name == key.name) {
          EXPECT_EQ(value_text(set), name) << key.name;
        }
      }
    }
    EXPECT_EQ(error_of_override(key.name + "=nonsense"),
              "--set " + key.name + "=nonsense: expected one of " + names + ", got \"nonsense\"");
  }
  EXPECT_EQ(choices, 10);
}

TEST(Config, AMountingIsThreeAnglesOrAuto) {
  EXPECT_EQ(default_config({"imu.rpy_body_imu=[0.1, 0, 1.5]"}).imu.rpy_body_imu.rpy,
            Eigen::Vector3d(0.1, 0, 1.5));
  EXPECT_FALSE(default_config({"imu.rpy_body_imu=auto"}).imu.rpy_body_imu.rpy);
  EXPECT_EQ(error_of_override("imu.rpy_body_imu=automatic"),
            "--set imu.rpy_body_imu=automatic: expected auto, or [roll, pitch, yaw], three numbers "
            "from -6.3 to 6.3 (rad), got \"automatic\"");
}

TEST(Config, OverrideErrorsQuoteTheOverride) {
  EXPECT_EQ(error_of_override("wheel.scale=abc"),
            "--set wheel.scale=abc: expected a number from 0.1 to 10, got \"abc\"");
  EXPECT_EQ(error_of_override("wheel.scale="),
            "--set wheel.scale=: expected a number from 0.1 to 10, got nothing");
  EXPECT_EQ(error_of_override("wheel.scale"), "--set wheel.scale: expected KEY=VALUE");
  EXPECT_EQ(error_of_override("=1"), "--set =1: expected KEY=VALUE");
  EXPECT_EQ(error_of_override("imu.rpy_body_imu=[0,0").rfind("--set imu.rpy_body_imu=[0,0: not", 0),
            0u);
}

std::vector<std::string> notices_of(const std::string& content) {
  const TemporaryFile file(content);
  std::vector<std::string> notices;
  load_config({file.path()}, {}, &notices);
  for (std::string& notice : notices) notice.replace(0, file.path().size(), "FILE");
  return notices;
}

TEST(Config, ARemovedKeyAtItsFixedValueIsANotice) {
  EXPECT_EQ(notices_of("wheel:\n  slip_lasts: 2e1\n  scale: 0.9\nimu: {adaptive_noise: yes}\n"
                       "gpr:\n  filter: {wavelet: sym4}\n  dec:\n    smoothing: 7.0\n"),
            std::vector<std::string>{
                "FILE: no longer settings; these keys have their default values and can be "
                "deleted: wheel.slip_lasts, imu.adaptive_noise, "
                "gpr.filter.wavelet, gpr.dec.smoothing"});
  EXPECT_TRUE(notices_of("wheel:\n  scale: 0.9\n").empty());
}

TEST(Config, ARemovedKeyAtAnotherValueIsAnErrorThatSaysWhatBecameOfIt) {
  EXPECT_EQ(
      error_of_file("wheel:\n  slip_lasts: 30\n"),
      "FILE:2: wheel.slip_lasts: no longer a setting: it is fixed at 20, since it depends on the "
      "ground ahead, which nobody knows; the IMU shows within it how the slip changes; got \"30\". "
      "Delete this key");
  EXPECT_EQ(
      error_of_file("gpr:\n  filter:\n    wavelet: none\n").rfind("FILE:3: gpr.filter.wavel", 0),
      0u);
  EXPECT_EQ(
      error_of_file("imu: {adaptive_noise: no}\n").rfind("FILE:1: imu.adaptive_noise: no l", 0),
      0u);
  EXPECT_EQ(error_of_file("graph:\n  settle: [1]\n").rfind("FILE:2: graph.settle: no longer", 0),
            0u);
  EXPECT_EQ(error_of_override("graph.settle=2").rfind("--set graph.settle=2: no longer", 0), 0u);
}

TEST(Config, AKeyWithAnotherNameIsReadByTheOldOne) {
  EXPECT_EQ(notices_of("gpr:\n  fusion: norm\n  sequential:\n    k: 0.05\n"),
            std::vector<std::string>{"FILE: keys with a new name: gpr.fusion (now "
                                     "paper.fusion), gpr.sequential.k (now paper.k)"});
  EXPECT_EQ(default_config({"gpr.sequential.k=0.05"}).gpr.sequential.k, 0.05);
  EXPECT_EQ(error_of_file("gpr:\n  fusion: sum\n"),
            "FILE:2: gpr.fusion: expected one of signed | norm, got \"sum\"");
}

// The tables against the fields: what is fixed is fixed at the default that the code has.
TEST(Config, AFileOfTheVersionBeforeIsReadAsTheDefaults) {
  const std::string path = std::string(GPRODOM_SOURCE_DIR) + "/test/package/gprodom-0.1.yaml";
  std::vector<std::string> notices;
  const Config config = load_config({path}, {}, &notices);
  Config defaults;
  defaults.wheel.max_speed = 5.0;  // the defaults of that version
  defaults.wheel.robust_threshold = 1.5;
  defaults.smoother.solver = SolverKind::kCeres;
  EXPECT_TRUE(differences(defaults, config).empty());
  ASSERT_EQ(notices.size(), 2u);
  for (const RemovedKey& key : removed_keys())
    EXPECT_NE(notices[0].find(" " + key.name), std::string::npos) << key.name;
  for (const MovedKey& key : moved_keys())
    EXPECT_NE(notices[1].find(" " + key.name + " (now "), std::string::npos) << key.name;
}

// A setting must be worth it: a user would set it and can know the value.
TEST(Config, HasNoMoreKeysThanAUserCanKnow) {
  Config config;
  std::size_t count = 0;
  for (const auto& key : config_keys(config)) count += key.name.rfind("channels.", 0) != 0;
  EXPECT_LE(count, 72u);
}

TEST(Config, APrefixIsPutBeforeTheChannelsLeftAtTheirDefaults) {
  const Config config = default_config({"channels.prefix=R1_", "channels.wheel=WHEEL_LEFT"});
  EXPECT_EQ(config.channels.imu, "R1_IMU");
  EXPECT_EQ(config.channels.sfm, "R1_SFM");
  EXPECT_EQ(config.channels.wheel, "WHEEL_LEFT");
  const TemporaryFile described(describe_config(config));
  EXPECT_TRUE(differences(config, load_config({described.path()})).empty());
  EXPECT_EQ(
      error_of_override("channels.prefix=" + std::string(49, 'x')).rfind("--set channels.p", 0),
      0u);
}

TEST(Config, MissingFileAndDirectoryAreErrors) {
  EXPECT_THROW(load_config({"/no/such/file.yaml"}), ConfigError);
  EXPECT_THROW(load_config({"/"}), ConfigError);
}

TEST(Config, DescriptionReadsBackEqual) {
  Config config = default_config({"wheel.scale=0.9734567890123456", "channels.imu='#odd: name'",
                                  "wheel.lever_arm=[1,2,-0.1]"});
  const TemporaryFile file(describe_config(config));
  EXPECT_TRUE(differences(config, load_config({file.path()})).empty());
  const auto changes = differences(Config(), config);
  ASSERT_EQ(changes.size(), 3u);
  EXPECT_EQ(changes[1].key, "wheel.scale");
  EXPECT_EQ(changes[1].before, "1");
  EXPECT_EQ(changes[1].after, "0.9734567890123456");
}

TEST(Config, FileInConfigFolderIsTheDescription) {
  EXPECT_EQ(bytes_of(std::string(GPRODOM_SOURCE_DIR) + "/config/gprodom.yaml"),
            describe_config(Config()))
      << "write it anew: gprodomd --print-config > config/gprodom.yaml";
}

TEST(Config, ProfilesLoad) {
  const Config cmu = load_config({std::string(GPRODOM_SOURCE_DIR) + "/config/cmu_gpr.yaml"});
  EXPECT_FALSE(differences(Config(), cmu).empty());
}

// The table names every field of Config: changing each through the table must be seen in the
// struct, so a field bound twice, or to another's name, shows.
TEST(Config, EveryKeyIsBoundOnce) {
  Config config;
  std::set<std::string> names;
  std::set<void*> fields;
  for (const auto& key : config_keys(config)) {
    EXPECT_TRUE(names.insert(key.name).second) << key.name;
    EXPECT_TRUE(
        fields.insert(std::visit([](auto* f) { return static_cast<void*>(f); }, key.field)).second)
        << key.name;
    EXPECT_FALSE(key.description.empty()) << key.name;
  }
}

}  // namespace
}  // namespace gprodom
