#include "base/file_writer.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "base/atomic_file.h"

namespace gprodom {

FileWriter::~FileWriter() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void FileWriter::write(const std::string& path, std::string bytes) {
  run(path, [path, bytes = std::move(bytes)] {
    write_whole(path, bytes);
    return Report{};
  });
}

void FileWriter::run(const std::string& path, std::function<Report()> work) {
  {
    const std::lock_guard lock(mutex_);
    const auto waiting = std::find_if(jobs_.begin(), jobs_.end(),
                                      [&path](const Job& job) { return job.path == path; });
    if (waiting != jobs_.end()) {
      waiting->work = std::move(work);
    } else {
      jobs_.push_back({path, std::move(work)});
    }
    if (!thread_.joinable()) thread_ = std::thread([this] { work_off(); });
  }
  wake_.notify_one();
}

void FileWriter::flush() {
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return jobs_.empty() && !writing_; });
}

std::vector<FileWriter::Outcome> FileWriter::take_outcomes() {
  const std::lock_guard lock(mutex_);
  return std::exchange(outcomes_, {});
}

void FileWriter::work_off() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    writing_ = true;
    lock.unlock();
    Outcome outcome{job.path, "", {}};
    try {
      outcome.report = job.work();
    } catch (const std::exception& error) {
      outcome.error = error.what();
    }
    lock.lock();
    writing_ = false;
    outcomes_.push_back(std::move(outcome));
    done_.notify_all();
  }
}

}  // namespace gprodom
