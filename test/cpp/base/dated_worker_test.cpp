#include "base/dated_worker.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace gprodom {
namespace {

// On its own thread a job must not end the process: what it throws is thrown where it is due.
TEST(DatedWorker, ThrowsWhereTheResultIsDue) {
  DatedWorker<int> worker(Execution::kThreaded);
  worker.submit(10, []() -> int { throw std::runtime_error("singular"); });
  worker.submit(20, [] { return 7; });
  worker.drain();
  EXPECT_THROW(worker.next_due(15), std::runtime_error);
  const auto due = worker.next_due(25);
  ASSERT_TRUE(due && due->result);
  EXPECT_EQ(*due->result, 7);
}

}  // namespace
}  // namespace gprodom
