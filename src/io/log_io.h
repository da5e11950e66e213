// LCM log files, read and written without loss.
#pragma once

#include <cstdint>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <vector>

#include "base/atomic_file.h"
#include "gprodom/lcm_io.h"

namespace gprodom {

// Reads a log from front to back. If it is damaged or cut off, all that is readable before and
// after the damage is used, and damage() describes the rest.
class LogReader {
 public:
  // Throws FileError where the file cannot be read or does not begin as an LCM log.
  explicit LogReader(const std::string& path);

  // The next event, valid until the next call; nullptr at the end.
  const lcm::LogEvent* next();

  // The share of the file that has been read, 0 to 1.
  double progress() const;

  // One line for each stretch that could not be read: file, event number, byte.
  const std::vector<std::string>& damage() const { return damage_; }

 private:
  std::int64_t find_event(std::int64_t from);
  bool event_fits() const;
  void note_damage(std::int64_t from, std::int64_t to);

  std::string path_;
  std::unique_ptr<lcm::LogFile> log_;
  std::int64_t size_ = 0;      // of the file, bytes
  std::int64_t position_ = 0;  // of the next event
  std::int64_t events_ = 0;    // read so far
  std::vector<std::string> damage_;
};

// Writes a log that appears at `path` when close() has succeeded, not before.
class LogWriter {
 public:
  // Throws FileError.
  explicit LogWriter(const std::string& path);

  // Stamped with the message's own data time, so that the same messages make the same file.
  // Throws FileError.
  void write(const LcmMessage& message);

  // Throws FileError where not everything reached the file.
  void close();

 private:
  AtomicFile file_;
  std::unique_ptr<lcm::LogFile> log_;
};

}  // namespace gprodom
