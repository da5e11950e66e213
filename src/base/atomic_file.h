// Files that appear whole or not at all, also where the power fails meanwhile.
#pragma once

#include <string>

namespace gprodom {

// Written beside its place, forced onto the disk and renamed into its place; then the folder is
// forced onto the disk as well, without which the renaming itself can be lost.
class AtomicFile {
 public:
  // Nothing is created yet. What is not a regular file (/dev/stdout, a pipe) is written in place.
  explicit AtomicFile(std::string path);
  // Removes what was written, unless it was put in place.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

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

// The whole file at once. Throws FileError.
void write_whole(const std::string& path, const std::string& bytes);

// All of a file. Throws FileError where it is there and cannot be read; false where it is not
// there.
bool read_whole(const std::string& path, std::string& bytes);

// Removes from a folder the working files of programs that have ended without a chance to do so: a
// power cut leaves one. A folder that cannot be read is left as it is.
void remove_abandoned(const std::string& folder);

}  // namespace gprodom
