// Work done off the fast path whose result takes effect at a fixed data time.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "base/background.h"
#include "gprodom/execution.h"
#include "gprodom/types.h"

namespace gprodom {

// Jobs run one after the other: on a background thread (kThreaded), or at once in submit()
// (kInline). An exception of a job is thrown again when its result is taken (kInline: by submit()).
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

  // kThreaded: the work begins at start(), or when a result is asked for.
  void submit(TimeNs effective, std::function<Result()> work) {
    if (!thread_.joinable()) {
      Result result = timed(work);
      jobs_.push_back({effective, {}, std::move(result), {}, nullptr});
      return;
    }
    const std::lock_guard lock(mutex_);
    jobs_.push_back({effective, std::move(work), std::nullopt, Clock::now(), nullptr});
    to_start_ = true;
  }

  // Starts the submitted jobs. Call it when the caller has nothing more urgent to do.
  void start() {
    if (std::exchange(to_start_, false)) wake_.notify_one();
  }

  struct Due {
    TimeNs effective;
    std::optional<Result> result;  // empty: not ready at its time
  };

  // The next job that is due. Its result is empty if the job is still running; it will be
  // discarded.
  std::optional<Due> next_due(TimeNs now) {
    start();
    const std::lock_guard lock(mutex_);
    const auto job = first_due(now);
    if (job == jobs_.end()) return std::nullopt;
    if (!job->done()) {
      job->abandoned = true;
      return Due{job->effective, std::nullopt};
    }
    return take(job);
  }

  // The same, but waits once for a late job, at most `patience` of wall-clock time. Its result is
  // empty if the job is still running; the next call asks for it again.
  std::optional<Due> await_due(TimeNs now, std::chrono::milliseconds patience) {
    start();
    std::unique_lock lock(mutex_);
    const auto job = first_due(now);
    if (job == jobs_.end()) return std::nullopt;
    if (!job->done() && !std::exchange(job->awaited, true))
      done_.wait_for(lock, patience, [&] { return job->done(); });
    if (!job->done()) return Due{job->effective, std::nullopt};
    return take(job);
  }

  // Wall-clock time of the jobs done so far.
  WorkTime work_time() {
    const std::lock_guard lock(mutex_);
    return work_time_;
  }

  // Waits until all submitted jobs are done.
  void drain() {
    start();
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return !thread_.joinable() || next_undone() == jobs_.end(); });
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    TimeNs effective;
    std::function<Result()> work;
    std::optional<Result> result;
    Clock::time_point submitted;  // kThreaded
    std::exception_ptr failure;   // exception of the job, to be thrown when its result is taken
    bool abandoned = false;
    bool awaited = false;
    bool done() const { return result.has_value() || failure; }
  };
  using JobIterator = typename std::deque<Job>::iterator;

  // Skips discarded jobs, and removes them once they are done.
  JobIterator first_due(TimeNs now) {
    while (!jobs_.empty() && jobs_.front().abandoned && jobs_.front().done()) jobs_.pop_front();
    auto job = jobs_.begin();
    while (job != jobs_.end() && job->abandoned) ++job;
    return job == jobs_.end() || job->effective > now ? jobs_.end() : job;
  }

  Due take(JobIterator job) {
    Due due{job->effective, std::move(job->result)};
    const std::exception_ptr failure = job->failure;
    jobs_.erase(job);
    if (failure) std::rethrow_exception(failure);
    return due;
  }

  Result timed(const std::function<Result()>& work) {
    const auto begin = Clock::now();
    Result result = work();
    const std::chrono::duration<double> spent = Clock::now() - begin;
    const std::lock_guard lock(mutex_);
    ++work_time_.jobs;
    work_time_.total_s += spent.count();
    work_time_.longest_s = std::max(work_time_.longest_s, spent.count());
    return result;
  }

  JobIterator next_undone() {
    auto job = jobs_.begin();
    while (job != jobs_.end() && job->done()) ++job;
    return job;
  }

  void run() {
    stay_in_background();
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stopping_ || next_undone() != jobs_.end(); });
      if (stopping_) return;
      const auto work = std::move(next_undone()->work);
      lock.unlock();
      std::optional<Result> result;
      std::exception_ptr failure;
      try {
        result = timed(work);
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      const auto job = next_undone();
      job->result = std::move(result);
      job->failure = failure;
      work_time_.ready.add(std::chrono::duration<double>(Clock::now() - job->submitted).count());
      done_.notify_all();
    }
  }

  std::mutex mutex_;  // guards jobs_, work_time_ and stopping_
  std::condition_variable wake_, done_;
  std::deque<Job> jobs_;
  WorkTime work_time_;
  bool stopping_ = false;
  bool to_start_ = false;  // the caller's thread only
  std::thread thread_;
};

}  // namespace gprodom
