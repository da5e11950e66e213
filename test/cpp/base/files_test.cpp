#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/atomic_file.h"
#include "base/folder_lock.h"
#include "gprodom/error.h"
#include "support/temporary_folder.h"

namespace fs = std::filesystem;

namespace {

// What the program asked of the file system, in order; and whether the disk is to fail.
std::vector<std::string> calls;  // NOLINT: the functions below have no other place for it
bool disk_fails = false;         // NOLINT

std::string path_of(int descriptor) {
  std::array<char, PATH_MAX> path{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t length = readlink(link.c_str(), path.data(), path.size());
  return {path.data(), static_cast<std::size_t>(std::max<ssize_t>(length, 0))};
}

}  // namespace

// In place of the C library's, which a program may replace.
extern "C" int fsync(int descriptor) {
  calls.push_back("fsync " + path_of(descriptor));
  if (disk_fails) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

extern "C" int rename(const char* from, const char* to) noexcept {
  calls.push_back(std::string("rename ") + from);
  return static_cast<int>(syscall(SYS_renameat, AT_FDCWD, from, AT_FDCWD, to));
}

namespace gprodom {
namespace {

class AtomicFileTest : public ::testing::Test {
 protected:
  AtomicFileTest() { calls.clear(); }
  ~AtomicFileTest() override { disk_fails = false; }
  std::string content() const {
    std::string bytes;
    return read_whole(path_, bytes) ? bytes : "absent";
  }
  std::size_t files() const { return folder_.files().size(); }

  TemporaryFolder folder_;
  const std::string path_ = folder_ / "pose.state";
};

// Otherwise a power cut leaves an empty file under the right name, or the file of before.
TEST_F(AtomicFileTest, TheFileIsOnTheDiskBeforeItIsRenamedAndTheFolderAfterwards) {
  write_whole(path_, "new");
  const std::string working = AtomicFile(path_).working_path();
  const std::vector<std::string> expected = {"fsync " + working, "rename " + working,
                                             "fsync " + folder_.path().string()};
  EXPECT_EQ(calls, expected);
  EXPECT_EQ(content(), "new");
  EXPECT_EQ(files(), 1U);
}

TEST_F(AtomicFileTest, FailingDiskLeavesTheOldFile) {
  write_whole(path_, "old");
  disk_fails = true;
  EXPECT_THROW(write_whole(path_, "new"), FileError);
  EXPECT_EQ(content(), "old");
  EXPECT_EQ(files(), 1U);
}

TEST_F(AtomicFileTest, FileWithoutPutInPlaceDoesNotAppear) {
  {
    const AtomicFile file(path_);
    std::ofstream(file.working_path()) << "half";
    EXPECT_EQ(content(), "absent");
  }
  EXPECT_EQ(files(), 0U);
}

TEST_F(AtomicFileTest, MissingFolderIsReported) {
  EXPECT_THROW(write_whole(folder_ / "later/pose.state", "new"), FileError);
}

TEST_F(AtomicFileTest, PipesAndDevicesAreWrittenDirectly) {
  AtomicFile file("/dev/null");
  EXPECT_EQ(file.working_path(), "/dev/null");
  file.put_in_place();
  EXPECT_TRUE(calls.empty());
}

// A program that dies in the middle, as in a power cut, and one that still writes.
TEST_F(AtomicFileTest, OnlyTemporaryFilesOfEndedProcessesAreRemoved) {
  const pid_t child = fork();
  if (child == 0) {
    const AtomicFile file(path_);
    std::ofstream(file.working_path()) << "half" << std::flush;
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const AtomicFile ours(path_);
  std::ofstream(ours.working_path()) << "half";
  for (const char* name : {"film.part", "1234", "pose.0.part"}) std::ofstream(folder_ / name);
  ASSERT_EQ(files(), 5U);
  remove_abandoned(folder_.path().string());
  EXPECT_EQ(files(), 4U);
  EXPECT_TRUE(fs::exists(ours.working_path()));
  remove_abandoned(folder_ / "later");  // not there: nothing to do
}

TEST_F(AtomicFileTest, FileSetAsideGetsTheFirstFreeName) {
  const std::string path = folder_ / "a.map";
  EXPECT_EQ(set_aside(path, false), "");
  for (int number = 1; number <= 3; ++number) {
    write_whole(path, std::to_string(number));
    const std::string kept = folder_ / ("a.kept-" + std::to_string(number) + ".map");
    EXPECT_EQ(set_aside(path, false), kept);
    EXPECT_FALSE(fs::exists(path));
    EXPECT_EQ(bytes_of(kept), std::to_string(number));
  }
}

// Where the power fails between the second name and the new file, there is a file all the time, and
// next time no third name.
TEST_F(AtomicFileTest, FileThatKeepsItsNameGetsOneMoreAlone) {
  const std::string path = folder_ / "a.map";
  write_whole(path, "before");
  const std::string kept = set_aside(path, true);
  EXPECT_TRUE(fs::exists(path));
  EXPECT_EQ(set_aside(path, true), kept);
  write_whole(path, "after");
  EXPECT_EQ(bytes_of(kept), "before");
  EXPECT_NE(set_aside(path, true), kept);
}

class FolderLockTest : public ::testing::Test {
 protected:
  static constexpr auto kAlone = FolderLock::Use::kAlone, kShared = FolderLock::Use::kShared;
  TemporaryFolder its_own_;
  const std::string folder_ = its_own_.path();
};

TEST_F(FolderLockTest, OneUserAloneAndItsProcessIsTold) {
  FolderLock one, two;
  EXPECT_TRUE(one.take(folder_, kAlone));
  EXPECT_TRUE(one.take(folder_, kAlone));  // has it already
  for (const auto use : {kAlone, kShared}) {
    try {
      two.take(folder_, use);
      FAIL();
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()).find("process " + std::to_string(getpid())),
                std::string::npos)
          << error.what();
    }
  }
}

TEST_F(FolderLockTest, UsersThatShareAreManyAndOneIsTheFirst) {
  FolderLock late;
  {
    FolderLock one, two, alone;
    EXPECT_TRUE(one.take(folder_, kShared));
    EXPECT_TRUE(two.take(folder_, kShared));
    EXPECT_TRUE(one.first());
    EXPECT_FALSE(two.first());
    EXPECT_THROW(alone.take(folder_, kAlone), FileError);
  }
  EXPECT_TRUE(late.take(folder_, kAlone));
  EXPECT_TRUE(late.first());
}

TEST_F(FolderLockTest, AKilledProcessLeavesNone) {
  std::array<int, 2> ready{};
  ASSERT_EQ(pipe(ready.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    FolderLock lock;
    const char taken = lock.take(folder_, kAlone) ? 'y' : 'n';
    if (write(ready[1], &taken, 1) == 1) pause();
    _exit(1);
  }
  char taken = 0;
  ASSERT_EQ(read(ready[0], &taken, 1), 1);
  ASSERT_EQ(taken, 'y');
  FolderLock lock;
  EXPECT_THROW(lock.take(folder_, kAlone), FileError);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(lock.take(folder_, kAlone));
  close(ready[0]);
  close(ready[1]);
}

TEST_F(FolderLockTest, AFolderThatIsNotThereYetIsLockedLater) {
  FolderLock lock;
  const std::string later = folder_ + "/later";
  EXPECT_FALSE(lock.take(later, kAlone));
  fs::create_directory(later);
  EXPECT_TRUE(lock.take(later, kAlone));
}

}  // namespace
}  // namespace gprodom
