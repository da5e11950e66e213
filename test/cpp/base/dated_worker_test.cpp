#include "base/dated_worker.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>

namespace gprodom {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// Work that is not done before it is let go.
class HeldWork {
 public:
  void let_go() { promise_.set_value(); }
  std::function<int()> giving(int result) const {
    return [open = open_, result] {
      open.wait();
      return result;
    };
  }

 private:
  std::promise<void> promise_;
  std::shared_future<void> open_ = promise_.get_future().share();
};

using Due = std::optional<DatedWorker<int>::Due>;

void expect_result(const Due& due, TimeNs effective, int result) {
  ASSERT_TRUE(due && due->result);
  EXPECT_EQ(due->effective, effective);
  EXPECT_EQ(*due->result, result);
}

void expect_late(const Due& due, TimeNs effective) {
  ASSERT_TRUE(due);
  EXPECT_EQ(due->effective, effective);
  EXPECT_FALSE(due->result);
}

// An exception on the worker's thread must not end the process: it is thrown when the result is
// due.
TEST(DatedWorker, ExceptionIsThrownWhenTheResultIsTaken) {
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, []() -> int { throw std::runtime_error("singular"); });
  worker.submit(20, [] { return 7; });
  worker.drain();
  EXPECT_THROW(worker.next_due(15), std::runtime_error);
  expect_result(worker.next_due(25), 20, 7);
}

// However early it is ready: the time at which it takes effect must not depend on the machine.
TEST(DatedWorker, ResultIsNotReturnedBeforeItsTime) {
  for (const Execution execution : {Execution::kInline, Execution::kThreaded}) {
    DatedWorker<int> worker(execution);
    worker.submit(10, [] { return 1; });
    worker.submit(20, [] { return 2; });
    worker.drain();
    EXPECT_FALSE(worker.next_due(9));
    EXPECT_FALSE(worker.await_due(9, milliseconds(0)));
    expect_result(worker.next_due(10), 10, 1);
    EXPECT_FALSE(worker.next_due(19));
    expect_result(worker.await_due(30, milliseconds(0)), 20, 2);
    EXPECT_FALSE(worker.next_due(1000));
  }
}

TEST(DatedWorker, LateJobIsDiscardedAndTheNextOneIsReturned) {
  HeldWork held;
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, held.giving(1));
  worker.submit(20, [] { return 2; });
  expect_late(worker.next_due(12), 10);
  EXPECT_FALSE(worker.next_due(12));  // returned once only
  held.let_go();
  worker.drain();
  expect_result(worker.next_due(25), 20, 2);
  EXPECT_FALSE(worker.next_due(1000));  // nor does it come afterwards
  EXPECT_EQ(worker.work_time().jobs, 2);
}

TEST(DatedWorker, ExceptionOfADiscardedJobIsDropped) {
  HeldWork held;
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, [work = held.giving(1)]() -> int {
    work();
    throw std::runtime_error("singular");
  });
  expect_late(worker.next_due(10), 10);
  held.let_go();
  worker.drain();
  EXPECT_FALSE(worker.next_due(1000));
}

TEST(DatedWorker, LateJobCanBeAwaited) {
  HeldWork held;
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, held.giving(1));
  std::thread later([&held] {
    std::this_thread::sleep_for(milliseconds(20));
    held.let_go();
  });
  expect_result(worker.await_due(10, seconds(60)), 10, 1);
  later.join();
}

// It waits once only, or a solver that hangs would delay every message of the sensors; its result
// is not thrown away.
TEST(DatedWorker, ResultComesLaterWhenWaitingTimesOut) {
  HeldWork held;
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, held.giving(1));
  worker.submit(20, [] { return 2; });
  const auto start = std::chrono::steady_clock::now();
  expect_late(worker.await_due(25, milliseconds(20)), 10);
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(20));
  expect_late(worker.await_due(25, seconds(60)), 10);  // at once
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(30));
  held.let_go();
  worker.drain();
  expect_result(worker.await_due(25, milliseconds(0)), 10, 1);
  expect_result(worker.await_due(25, milliseconds(0)), 20, 2);
}

}  // namespace
}  // namespace gprodom
