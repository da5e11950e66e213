// A bounded queue between two threads. Its producer never waits: items that do not fit are dropped
// and counted.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

namespace gprodom {

template <class Item>
class MessageQueue {
 public:
  explicit MessageQueue(std::size_t capacity) : capacity_(capacity) {}

  // Any thread. False where the item was dropped: the queue is full or closed.
  bool push(Item item) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (closed_ || items_.size() >= capacity_) {
        if (!closed_) ++dropped_;
        return false;
      }
      items_.push_back(std::move(item));
      longest_ = std::max(longest_, items_.size());
    }
    filled_.notify_one();
    return true;
  }

  // Consumer only. Returns all items in order; waits for the first one until `timeout` or until the
  // queue is closed.
  std::vector<Item> pop_all(std::chrono::milliseconds timeout) {
    std::vector<Item> items;
    std::unique_lock<std::mutex> lock(mutex_);
    filled_.wait_for(lock, timeout, [this] { return closed_ || !items_.empty(); });
    items.swap(items_);
    return items;
  }

  // Items dropped since the last call.
  std::int64_t take_dropped() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(dropped_, 0);
  }

  // Most items that waited at once since the last call.
  std::size_t take_longest() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(longest_, items_.size());
  }

  // Refuses new items; those inside can still be popped.
  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      closed_ = true;
    }
    filled_.notify_all();
  }

  // Closed and empty.
  bool finished() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return closed_ && items_.empty();
  }

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::vector<Item> items_;   // guarded by mutex_
  std::size_t longest_ = 0;   // guarded by mutex_
  std::int64_t dropped_ = 0;  // guarded by mutex_
  bool closed_ = false;       // guarded by mutex_
};

}  // namespace gprodom
