#include "io/log_io.h"

#include <gtest/gtest.h>

#include <fstream>

#include "gprodom/error.h"
#include "io/tum.h"
#include "support/temporary_folder.h"

namespace gprodom {
namespace {

class LogIo : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  // Ten messages of growing size.
  void write_log(const std::string& name) const {
    LogWriter writer(path(name));
    for (int i = 0; i < 10; ++i) writer.write(message(i));
    writer.close();
  }

  static LcmMessage message(int i) {
    return {1000 + i, "CHANNEL_" + std::to_string(i),
            std::vector<std::uint8_t>(static_cast<std::size_t>(i) * 100, std::uint8_t(i))};
  }

  std::string content(const std::string& name) const { return bytes_of(path(name)); }

  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }

  struct Read {
    std::vector<std::int64_t> times;
    std::vector<std::string> damage;  // what else there was
  };
  Read read(const std::string& name) const {
    LogReader reader(path(name));
    std::vector<std::int64_t> times;
    while (const lcm::LogEvent* event = reader.next()) {
      const LcmMessage expected = message(static_cast<int>(event->timestamp - 1000));
      EXPECT_EQ(event->channel, expected.channel);
      EXPECT_EQ(event->datalen, static_cast<int>(expected.data.size()));
      times.push_back(event->timestamp);
    }
    EXPECT_EQ(reader.next(), nullptr);
    EXPECT_DOUBLE_EQ(reader.progress(), 1.0);
    return {times, reader.damage()};
  }

  TemporaryFolder folder_;
};

TEST_F(LogIo, ReadsBackWhatWasWritten) {
  write_log("a.lcmlog");
  write_log("b.lcmlog");
  EXPECT_EQ(read("a.lcmlog").times.size(), 10u);
  EXPECT_TRUE(read("a.lcmlog").damage.empty());
  EXPECT_EQ(content("a.lcmlog"), content("b.lcmlog"));
}

// Cut at every byte of the last two events: complete events are read, and a cut that is not between
// events is told of once.
TEST_F(LogIo, TruncatedLogGivesWhatIsReadable) {
  write_log("a.lcmlog");
  const std::string whole = content("a.lcmlog");
  const std::size_t last = 28 + 9 + 900;
  const std::size_t before = 28 + 9 + 800;
  for (std::size_t cut = 0; cut < last + before; cut += 7) {
    put("cut.lcmlog", whole.substr(0, whole.size() - cut));
    const std::size_t expected = cut == 0 ? 10 : cut <= last ? 9 : 8;
    const auto [times, damage] = read("cut.lcmlog");
    EXPECT_EQ(times.size(), expected) << cut;
    ASSERT_EQ(damage.size(), cut == 0 || cut == last ? 0u : 1u) << cut;
    if (!damage.empty()) {
      EXPECT_NE(damage[0].find("event " + std::to_string(expected) + " (byte"), std::string::npos)
          << damage[0];
    }
  }
}

TEST_F(LogIo, DamageInTheMiddleIsSkippedAndReported) {
  write_log("a.lcmlog");
  std::string bytes = content("a.lcmlog");
  std::size_t fifth = 0;
  for (int i = 0; i < 5; ++i) fifth += 28 + 9 + 100 * static_cast<std::size_t>(i);
  for (std::size_t i = 0; i < 28; ++i) bytes[fifth + i] = '\xff';
  put("bad.lcmlog", bytes);
  const auto [times, damage] = read("bad.lcmlog");
  // The event before is lost with it: its end cannot be told.
  EXPECT_EQ(times, (std::vector<std::int64_t>{1000, 1001, 1002, 1003, 1006, 1007, 1008, 1009}));
  ASSERT_EQ(damage.size(), 1u);
  EXPECT_NE(damage[0].find("event 4 (byte"), std::string::npos) << damage[0];
}

TEST_F(LogIo, OtherFilesAreRefused) {
  put("text", "This is no log, and is long enough not to be taken for one.\n");
  put("empty", "");
  EXPECT_THROW(LogReader(path("text")), FileError);
  EXPECT_THROW(LogReader(path("empty")), FileError);
  EXPECT_THROW(LogReader(path("missing")), FileError);
  EXPECT_THROW(LogReader(folder_.path().string()), FileError);
}

TEST_F(LogIo, IncompleteFileIsRemoved) {
  {
    LogWriter writer(path("out.lcmlog"));
    writer.write(message(3));
    TumWriter tum(path("out.tum"));
  }
  EXPECT_TRUE(folder_.files().empty());
  EXPECT_THROW(LogWriter(path("no/such/folder/out.lcmlog")), FileError);
}

TEST_F(LogIo, FullDiskIsAnError) {
  LogWriter writer("/dev/full");
  EXPECT_THROW(
      {
        for (int i = 0; i < 10000; ++i) writer.write(message(9));
        writer.close();
      },
      FileError);
  TumWriter tum("/dev/full");
  tum.write({});
  EXPECT_THROW(tum.close(), FileError);
}

TEST_F(LogIo, TumKeepsNanoseconds) {
  TumWriter tum(path("a.tum"));
  OdometryEstimate pose;
  pose.time = 1'700'001'000'000'000'001;
  pose.p_odom_body = {1.5, -2, 0.25};
  tum.write(pose);
  tum.close();
  EXPECT_EQ(content("a.tum"),
            "# time x y z qx qy qz qw\n"
            "1700001000.000000001 1.500000000 -2.000000000 0.250000000 "
            "0.000000000000 0.000000000000 0.000000000000 1.000000000000\n");
}

}  // namespace
}  // namespace gprodom
