// Trajectories in the TUM format: one pose a line, `time x y z qx qy qz qw`, seconds and metres.
#pragma once

#include <fstream>
#include <string>

#include "base/atomic_file.h"
#include "gprodom/types.h"

namespace gprodom {

// Writes a file that appears at `path` when close() has succeeded, not before.
class TumWriter {
 public:
  // Throws FileError.
  explicit TumWriter(const std::string& path);

  // Time is written to the nanosecond, numbers to the micrometre and below.
  void write(const OdometryEstimate& pose);

  // Throws FileError where not everything reached the file.
  void close();

 private:
  AtomicFile file_;
  std::ofstream stream_;
};

}  // namespace gprodom
