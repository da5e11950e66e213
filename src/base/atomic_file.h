// Files that appear complete or not at all, even if the power fails while they are written.
#pragma once

#include <string>

namespace gprodom {

// The file is written under another name, synchronised to disk and renamed. Then the folder is
// synchronised too, or the renaming itself could be lost.
class AtomicFile {
 public:
  // Creates nothing yet. A path that is not a regular file (/dev/stdout, a pipe) is written
  // directly.
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

// Throws FileError with what errno says.
[[noreturn]] void fail(const std::string& path, const std::string& what);

// The whole file at once. Throws FileError.
void write_whole(const std::string& path, const std::string& bytes);

// Reads a whole file. False if it does not exist; throws FileError if it cannot be read.
bool read_whole(const std::string& path, std::string& bytes);

// Gives a file another name beside it, FOLDER/NAME.kept-N.ENDING with the first N from 1 that is
// free. Returns that path; empty if there is no such file. Throws FileError.
// keep_both: the file keeps its own name as well, so that at no time it is without a file; one that
// has such a second name already gets no other. Where the file system has no second names (FAT), it
// loses its own.
std::string set_aside(const std::string& path, bool keep_both);

// Removes temporary files of processes that no longer run (a power cut leaves one) from a folder. A
// folder that cannot be read is left as it is.
void remove_abandoned(const std::string& folder);

}  // namespace gprodom
