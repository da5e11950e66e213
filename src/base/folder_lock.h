// A lock on a folder, for processes that keep files in it. It ends with the process, however that
// ends, so that none is ever left behind.
#pragma once

#include <string>

namespace gprodom {

class FolderLock {
 public:
  enum class Use { kShared, kAlone };

  FolderLock() = default;
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  // Locks FOLDER/lock, which is made if it does not exist: kAlone, or kShared with other users that
  // share. Nothing changes if this holds it already. False if the file cannot be made or opened (no
  // such folder, or it cannot be written): a later call tries again. Throws FileError if another
  // user has it, also one of this process; the error names its process.
  bool take(const std::string& folder, Use use);

  bool held() const { return file_ >= 0; }
  // Of the users that share, one is the first: what only one may write is its own.
  bool first() const { return first_; }

 private:
  int file_ = -1;
  bool first_ = false;
};

}  // namespace gprodom
