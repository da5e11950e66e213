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

// Jobs run one after the other, on a thread of their own in the background (kThreaded) or at once
// (kInline). What one throws is thrown again where its result is asked for (kInline: where it is
// submitted).
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

  // kThreaded: the work begins with start(), or where a result is asked for.
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

  // Lets the thread take up what was submitted: the caller has nothing more urgent left to do.
  void start() {
    if (std::exchange(to_start_, false)) wake_.notify_one();
  }

  struct Due {
    TimeNs effective;
    std::optional<Result> result;  // empty: not ready at its time
  };

  // The next job whose time has come. Empty result: it is still being worked on, and will be thrown
  // away.
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

  // The same, but a job that is late is waited for, `patience` of wall-clock time at most and once.
  // Empty result: it is still being worked on, and will be asked for again.
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

  // Until all that was submitted is done.
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
    std::exception_ptr failure;   // what the work threw, for whoever asks for its result
    bool abandoned = false;
    bool awaited = false;
    bool done() const { return result.has_value() || failure; }
  };
  using JobIterator = typename std::deque<Job>::iterator;

  // What was abandoned is passed over, and forgotten once it is done.
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
