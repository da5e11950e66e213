// Writes files on its own thread, so that no other thread waits for a slow disk.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace gprodom {

class FileWriter {
 public:
  FileWriter() = default;
  ~FileWriter();  // writes what still waits
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  // Any thread; never waits. Writes as write_whole() does. Replaces a job for the same path that
  // has not begun.
  void write(const std::string& path, std::string bytes);

  // What a job reports; done: false where it found nothing that it could write.
  struct Report {
    bool done = true;
    std::vector<std::string> told;
  };
  // The same for a job that writes this path by itself. Its exceptions are its outcome.
  void run(const std::string& path, std::function<Report()> work);

  // Waits until all jobs are written or have failed.
  void flush();

  // The outcome of each job since the last call; error is empty if the file is on disk.
  struct Outcome {
    std::string path, error;
    Report report;
  };
  std::vector<Outcome> take_outcomes();

 private:
  struct Job {
    std::string path;
    std::function<Report()> work;
  };
  void work_off();

  std::mutex mutex_;  // guards all below but the thread
  std::condition_variable wake_, done_;
  std::deque<Job> jobs_;
  std::vector<Outcome> outcomes_;
  bool writing_ = false, stopping_ = false;
  std::thread thread_;  // from the first job on
};

}  // namespace gprodom
