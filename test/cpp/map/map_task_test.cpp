#include "map/map_task.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <thread>

namespace gprodom {
namespace {

// Two savings, of which the first is under way until later: the disk is slow.
class SlowSavings {
 public:
  explicit SlowSavings(MapTask& task) {
    task.save_ground(0, [this](const std::string& bytes) {
      release_.get_future().wait();
      saved_.push_back(bytes);
    });
    task.save_ground(0, [this](const std::string& bytes) { saved_.push_back(bytes); });
    later_ = std::thread([this] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      release_.set_value();
    });
  }
  ~SlowSavings() { later_.join(); }
  std::size_t saved() const { return saved_.size(); }

 private:
  std::promise<void> release_;
  std::vector<std::string> saved_;
  std::thread later_;
};

TEST(MapTask, DestructorFinishesARequestedSaving) {
  auto task = std::make_unique<MapTask>(default_config(), Execution::kThreaded);
  const SlowSavings savings(*task);
  task.reset();
  EXPECT_EQ(savings.saved(), 2U);
}

TEST(MapTask, TakingTheGroundWaitsForTheSaving) {
  MapTask task(default_config(), Execution::kThreaded);
  const SlowSavings savings(task);
  task.take_ground();
  EXPECT_EQ(savings.saved(), 2U);
}

TEST(MapTask, BytesOfTheGroundWaitForTheJobsBefore) {
  MapTask task(default_config(), Execution::kThreaded);
  const SlowSavings savings(task);
  EXPECT_FALSE(task.ground_bytes().empty());
  EXPECT_EQ(savings.saved(), 2U);
}

}  // namespace
}  // namespace gprodom
