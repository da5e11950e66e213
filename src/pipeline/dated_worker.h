// Work done off the fast path whose result takes effect at a fixed data time.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "gprodom/odometry.h"
#include "gprodom/types.h"

namespace gprodom {

// Jobs run one after the other, on a thread of their own (kThreaded) or at once (kInline).
template <typename Result>
class DatedWorker {
 public:
  explicit DatedWorker(Execution execution) {
    if (execution == Execution::kThreaded) thread_ = std::thread([this] { run(); });
  }
  ~DatedWorker() {
    if (!thread_.joinable()) return;
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  DatedWorker(const DatedWorker&) = delete;
  DatedWorker& operator=(const DatedWorker&) = delete;

  void submit(TimeNs effective, std::function<Result()> work) {
    if (!thread_.joinable()) {
      jobs_.push_back({effective, {}, work()});
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back({effective, std::move(work), std::nullopt});
    }
    wake_.notify_one();
  }

  struct Due {
    TimeNs effective;
    std::optional<Result> result;  // empty: not ready at its time
  };

  // The next job whose time has come. Empty result: it is still being worked on; with `wait_late`
  // the job stays and is asked for again, without it the job's result will be thrown away.
  std::optional<Due> next_due(TimeNs now, bool wait_late) {
    const std::lock_guard lock(mutex_);
    while (!jobs_.empty() && jobs_.front().abandoned && jobs_.front().result) jobs_.pop_front();
    auto job = jobs_.begin();
    while (job != jobs_.end() && job->abandoned) ++job;
    if (job == jobs_.end() || job->effective > now) return std::nullopt;
    Due due{job->effective, std::move(job->result)};
    if (due.result)
      jobs_.erase(job);
    else if (!wait_late)
      job->abandoned = true;
    return due;
  }

  size_t pending() {
    const std::lock_guard lock(mutex_);
    return jobs_.size();
  }

  // Until all that was submitted is done.
  void drain() {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return !thread_.joinable() || next_undone() == jobs_.end(); });
  }

 private:
  struct Job {
    TimeNs effective;
    std::function<Result()> work;
    std::optional<Result> result;
    bool abandoned = false;
  };

  typename std::deque<Job>::iterator next_undone() {
    auto job = jobs_.begin();
    while (job != jobs_.end() && job->result) ++job;
    return job;
  }

  void run() {
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stopping_ || next_undone() != jobs_.end(); });
      if (stopping_) return;
      const auto work = std::move(next_undone()->work);
      lock.unlock();
      Result result = work();
      lock.lock();
      next_undone()->result = std::move(result);
      done_.notify_all();
    }
  }

  std::mutex mutex_;  // guards jobs_ and stopping_
  std::condition_variable wake_, done_;
  std::deque<Job> jobs_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace gprodom
