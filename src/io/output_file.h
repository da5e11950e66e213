// A file that appears whole or not at all: written beside its place, then renamed into it.
#pragma once

#include <string>

namespace gprodom {

class OutputFile {
 public:
  // Nothing is created yet. What is not a regular file (/dev/stdout, a pipe) is written in place.
  explicit OutputFile(std::string path);
  // Removes what was written, unless it was put in place.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  const std::string& path() const { return path_; }
  // Where to write until put_in_place().
  const std::string& working_path() const { return working_path_; }

  // Call when the file is written and closed. Throws FileError.
  void put_in_place();

 private:
  std::string path_;
  std::string working_path_;
  bool in_place_ = false;
};

}  // namespace gprodom
