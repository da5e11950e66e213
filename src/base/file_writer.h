// Files written on a thread of its own, so that a slow disk makes nobody wait.
#pragma once

#include <condition_variable>
#include <deque>
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

  // Any thread; never waits. As write_whole() does it. What still waits for the same path is
  // replaced.
  void write(const std::string& path, std::string bytes);

  // Until all that was given is written, or has failed.
  void flush();

  // How what was written since the last call has ended: error is empty where it is on disk.
  struct Outcome {
    std::string path, error;
  };
  std::vector<Outcome> take_outcomes();

 private:
  struct Job {
    std::string path, bytes;
  };
  void run();

  std::mutex mutex_;  // guards all below but the thread
  std::condition_variable wake_, done_;
  std::deque<Job> jobs_;
  std::vector<Outcome> outcomes_;
  bool writing_ = false, stopping_ = false;
  std::thread thread_;  // from the first job on
};

}  // namespace gprodom
