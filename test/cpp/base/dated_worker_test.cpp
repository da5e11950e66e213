#include "base/dated_worker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <stdexcept>
#include <thread>

#include "support/gate.h"

namespace gprodom {
namespace {

// Work that is not done before the gate is opened.
std::function<int()> held_by(const Gate& gate, int result) {
  return [&gate, result] {
    gate.wait();
    return result;
  };
}

using Due = std::optional<DatedWorker<int>::Due>;

void expect_result(const Due& due, TimeNs effective, int result) {
  ASSERT_TRUE(due);
  EXPECT_EQ(due->effective, effective);
  EXPECT_EQ(due->result, result);
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
    expect_result(worker.next_due(10), 10, 1);
    EXPECT_FALSE(worker.next_due(19));
    expect_result(worker.next_due(30), 20, 2);
    EXPECT_FALSE(worker.next_due(1000));
    EXPECT_EQ(worker.take_late(1000), 0U);
    EXPECT_EQ(worker.drop_late(1000), 0U);
    EXPECT_EQ(worker.withdraw_late(1000), 0U);
  }
}

// Nobody waits for it, or a slow solver would hold up every pose; and it is counted once.
TEST(DatedWorker, LateResultComesWhenItIsThere) {
  Gate held;
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, held_by(held, 1));
  worker.submit(20, [] { return 2; });
  EXPECT_FALSE(worker.next_due(9));
  EXPECT_EQ(worker.take_late(9), 0U);
  EXPECT_FALSE(worker.next_due(12));
  EXPECT_EQ(worker.take_late(12), 1U);
  EXPECT_FALSE(worker.next_due(25));
  EXPECT_EQ(worker.take_late(25), 1U);  // the second: it waits behind the first
  held.open();
  worker.drain();
  expect_result(worker.next_due(26), 10, 1);
  expect_result(worker.next_due(26), 20, 2);
  EXPECT_EQ(worker.take_late(26), 0U);
}

TEST(DatedWorker, LateJobIsDroppedWithItsExceptionAndTheNextOneIsReturned) {
  Gate held;
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, [work = held_by(held, 1)]() -> int {
    work();
    throw std::runtime_error("singular");
  });
  worker.submit(20, [] { return 2; });
  EXPECT_EQ(worker.drop_late(9), 0U);
  EXPECT_EQ(worker.drop_late(12), 1U);
  EXPECT_EQ(worker.drop_late(12), 0U);  // told once only
  EXPECT_FALSE(worker.next_due(12));
  held.open();
  worker.drain();
  expect_result(worker.next_due(25), 20, 2);
  EXPECT_FALSE(worker.next_due(1000));  // nor does it come afterwards
}

TEST(DatedWorker, WhatWaitsBehindADroppedJobIsNotRun) {
  Gate held;
  DatedWorker<int> worker(Execution::kThreaded);
  int begun = 0;
  worker.submit(10, [&begun, work = held_by(held, 1)] {
    ++begun;
    return work();
  });
  for (const int effective : {20, 30, 40}) {
    worker.submit(effective, [&begun, effective] {
      ++begun;
      return effective;
    });
  }
  EXPECT_EQ(worker.drop_late(22), 3U);
  EXPECT_LE(worker.waiting(), 2U);  // the one that runs may not have begun
  held.open();
  worker.drain();
  EXPECT_LE(begun, 2);
  expect_result(worker.next_due(50), 40, 40);
}

TEST(DatedWorker, JobsThatWaitAreTakenBackOnceTheOldestIsDue) {
  Gate held;
  DatedWorker<int> worker(Execution::kThreaded);
  std::promise<void> begun;
  worker.submit(10, [&begun, work = held_by(held, 1)] {
    begun.set_value();
    return work();
  });
  worker.start();
  begun.get_future().wait();
  worker.submit(20, [] { return 2; });
  worker.submit(30, [] { return 3; });
  EXPECT_EQ(worker.withdraw_late(15), 0U);  // the one that is due has begun
  EXPECT_EQ(worker.waiting(), 2U);
  EXPECT_EQ(worker.withdraw_late(20), 2U);
  worker.submit(40, [] { return 4; });
  held.open();
  worker.drain();
  expect_result(worker.next_due(50), 10, 1);
  expect_result(worker.next_due(50), 40, 4);
}

// A virtual clock in tenths of a tick: a job is let go when its time is over, so that the machine's
// speed does not matter.
TEST(DatedWorker, JobsSlowerThanTheirPeriodEndInASteadyState) {
  constexpr TimeNs kTick = 10, kTakes = 12, kBudget = 50;
  std::atomic<int> running{0}, let_go{0};         // numbers of jobs
  DatedWorker<int> worker(Execution::kThreaded);  // ends first: its jobs use what is above
  const auto work = [&](int number) {
    return [&, number] {
      running = number;
      while (let_go < number) std::this_thread::yield();
      return number;
    };
  };
  const auto await_running = [&](int other_than) {
    while (running == other_than) std::this_thread::yield();
    return running.load();
  };
  std::size_t dropped = 0, most = 0;
  int submitted = 0, answered = 0, now_running = 0, newest = 0;
  TimeNs ends = 0;
  for (TimeNs now = 0; submitted < 1000; ++now) {
    if (now_running > 0 && now >= ends) {
      const auto before = worker.work_time().ready.count();
      const bool another = worker.waiting() > 0;
      let_go = now_running;
      while (worker.work_time().ready.count() == before) std::this_thread::yield();
      now_running = another ? await_running(now_running) : 0;
      ends = now + kTakes;
    }
    if (now % kTick == 0) {
      worker.submit(now + kBudget, work(++submitted));
      worker.start();
      if (now_running == 0) {
        now_running = await_running(now_running);
        ends = now + kTakes;
      }
    }
    dropped += worker.drop_late(now);
    while (const auto due = worker.next_due(now)) {
      ++answered;
      newest = due->result;
    }
    if (submitted > 500) most = std::max(most, worker.waiting());
  }
  EXPECT_LE(most, 5U);       // those within the budget
  EXPECT_GT(answered, 700);  // of the 833 that can be
  EXPECT_LT(submitted - newest, 10);
  EXPECT_NEAR(answered + static_cast<double>(dropped), submitted, 6);
  let_go = submitted;
}

}  // namespace
}  // namespace gprodom
