#include "live/message_queue.h"

#include <gtest/gtest.h>

#include <thread>

namespace gprodom {
namespace {

using std::chrono::milliseconds;

TEST(MessageQueue, DropsAndCountsWhatDoesNotFit) {
  MessageQueue<int> queue(3);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(queue.push(i), i < 3);
  EXPECT_EQ(queue.take_dropped(), 2);
  EXPECT_EQ(queue.take_dropped(), 0);
  EXPECT_EQ(queue.pop_all(milliseconds(0)), (std::vector<int>{0, 1, 2}));
  EXPECT_TRUE(queue.push(5));
}

TEST(MessageQueue, ClosedQueueReturnsItsItems) {
  MessageQueue<int> queue(3);
  queue.push(1);
  queue.close();
  EXPECT_FALSE(queue.push(2));
  EXPECT_EQ(queue.take_dropped(), 0);  // at the end nothing is lost that was asked for
  EXPECT_FALSE(queue.finished());
  EXPECT_EQ(queue.pop_all(milliseconds(0)).size(), 1u);
  EXPECT_TRUE(queue.finished());
}

TEST(MessageQueue, ManyProducersLoseNothingThatFits) {
  constexpr int kEach = 20000;
  MessageQueue<int> queue(2 * kEach);
  std::vector<int> received;
  std::thread consumer([&] {
    while (!queue.finished()) {
      for (const int item : queue.pop_all(milliseconds(1000))) received.push_back(item);
    }
  });
  auto produce = [&](int first) {
    for (int i = 0; i < kEach; ++i) queue.push(first + 2 * i);
  };
  std::thread odd(produce, 1);
  produce(0);
  odd.join();
  queue.close();
  consumer.join();
  ASSERT_EQ(received.size(), 2u * kEach);
  int next[2] = {0, 1};  // each producer's items stay in order
  for (const int item : received) {
    EXPECT_EQ(item, next[item % 2]);
    next[item % 2] += 2;
  }
}

}  // namespace
}  // namespace gprodom
