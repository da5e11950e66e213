// Work done off the fast path whose result takes effect at a fixed data time.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <iterator>
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
// Nobody waits for a job that is late. Whoever submits jobs decides what becomes of it: its result
// comes when it is there (take_late()), is not wanted any more (drop_late()), or the work is done
// together with that of later jobs (withdraw_late()). With kInline no job is ever late.
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
      Job job{effective, {}, timed(work), {}, nullptr};
      job.begun = true;
      jobs_.push_back(std::move(job));
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
    Result result;
  };

  // The result of the oldest job if it is due and done; the jobs behind it come after it. Never
  // waits.
  std::optional<Due> next_due(TimeNs now) {
    start();
    const std::lock_guard lock(mutex_);
    const auto job =
        std::find_if(jobs_.begin(), jobs_.end(), [](const Job& j) { return !j.dropped; });
    if (job == jobs_.end() || job->effective > now || !job->done()) return std::nullopt;
    return take(job);
  }

  // Call it when next_due() gives nothing more: how many jobs have become late since the last call,
  // that is, are due without a result. The results come later.
  std::size_t take_late(TimeNs now) {
    const std::lock_guard lock(mutex_);
    std::size_t late = 0;
    for (Job& job : jobs_) {
      if (job.effective <= now && !job.dropped && !std::exchange(job.late, true)) ++late;
    }
    return late;
  }

  // Drops the jobs that are due and not done: their results would come too late. What waits behind
  // such a job would be late as well, so only the newest job may stay, which can catch up. Returns
  // how many jobs were dropped.
  std::size_t drop_late(TimeNs now) {
    start();
    const std::lock_guard lock(mutex_);
    const auto is_late = [now](const Job& job) {
      return job.effective <= now && !job.done() && !job.dropped;
    };
    if (std::none_of(jobs_.begin(), jobs_.end(), is_late)) return 0;
    std::size_t dropped = 0;
    for (auto job = jobs_.begin(); job != jobs_.end();) {
      const bool may_catch_up = !is_late(*job) && (job->begun || std::next(job) == jobs_.end());
      if (job->done() || job->dropped || may_catch_up) {
        ++job;
        continue;
      }
      ++dropped;
      if (job->begun) {
        job->dropped = true;
        ++job;
      } else {
        job = jobs_.erase(job);
      }
    }
    return dropped;
  }

  // Takes back all jobs that have not begun if the oldest of them is due. Returns how many.
  std::size_t withdraw_late(TimeNs now) {
    const std::lock_guard lock(mutex_);
    const auto first = first_waiting();
    if (first == jobs_.end() || first->effective > now) return 0;
    const auto withdrawn = static_cast<std::size_t>(std::distance(first, jobs_.end()));
    jobs_.erase(first, jobs_.end());
    return withdrawn;
  }

  // Jobs that have not begun.
  std::size_t waiting() {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(std::distance(first_waiting(), jobs_.end()));
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
    done_.wait(lock, [this] {
      return std::all_of(jobs_.begin(), jobs_.end(), [](const Job& job) { return job.done(); });
    });
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    TimeNs effective;
    std::function<Result()> work;
    std::optional<Result> result;
    Clock::time_point submitted;  // kThreaded
    std::exception_ptr failure;   // exception of the job, to be thrown when its result is taken
    bool begun = false;
    bool late = false;     // told by take_late()
    bool dropped = false;  // it runs, and its result is not wanted
    bool done() const { return result.has_value() || failure; }
  };
  using JobIterator = typename std::deque<Job>::iterator;

  Due take(JobIterator job) {
    const TimeNs effective = job->effective;
    std::optional<Result> result = std::move(job->result);
    const std::exception_ptr failure = job->failure;
    jobs_.erase(job);
    if (failure) std::rethrow_exception(failure);
    return {effective, *std::move(result)};
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

  JobIterator first_waiting() {
    return std::find_if(jobs_.begin(), jobs_.end(), [](const Job& job) { return !job.begun; });
  }

  void run() {
    stay_in_background();
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stopping_ || first_waiting() != jobs_.end(); });
      if (stopping_) return;
      const auto next = first_waiting();
      next->begun = true;
      const auto work = std::move(next->work);
      lock.unlock();
      std::optional<Result> result;
      std::exception_ptr failure;
      try {
        result = timed(work);
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      finish(std::move(result), failure);
      done_.notify_all();
    }
  }

  // Of the job that runs. Others may have been removed meanwhile.
  void finish(std::optional<Result> result, const std::exception_ptr& failure) {
    const auto job =
        std::find_if(jobs_.begin(), jobs_.end(), [](const Job& j) { return j.begun && !j.done(); });
    work_time_.ready.add(std::chrono::duration<double>(Clock::now() - job->submitted).count());
    if (job->dropped) {
      jobs_.erase(job);
      return;
    }
    job->result = std::move(result);
    job->failure = failure;
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
