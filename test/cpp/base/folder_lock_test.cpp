#include "base/folder_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>

#include "gprodom/error.h"
#include "support/temporary_folder.h"

namespace gprodom {
namespace {

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
  std::filesystem::create_directory(later);
  EXPECT_TRUE(lock.take(later, kAlone));
}

}  // namespace
}  // namespace gprodom
