#include "base/file_writer.h"

#include <algorithm>
#include <utility>

#include "base/atomic_file.h"
#include "gprodom/error.h"

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
  {
    const std::lock_guard lock(mutex_);
    const auto waiting = std::find_if(jobs_.begin(), jobs_.end(),
                                      [&path](const Job& job) { return job.path == path; });
    if (waiting != jobs_.end()) {
      waiting->bytes = std::move(bytes);
    } else {
      jobs_.push_back({path, std::move(bytes)});
    }
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
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

void FileWriter::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    writing_ = true;
    lock.unlock();
    Outcome outcome{job.path, ""};
    try {
      write_whole(job.path, job.bytes);
    } catch (const FileError& error) {
      outcome.error = error.what();
    }
    lock.lock();
    writing_ = false;
    outcomes_.push_back(std::move(outcome));
    done_.notify_all();
  }
}

}  // namespace gprodom
