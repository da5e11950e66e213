#include "base/folder_lock.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "gprodom/error.h"

namespace gprodom {
namespace {

// The file of a folder that only its owner can write is opened for reading, which is enough to
// share it.
int opened(const std::string& path, FolderLock::Use use) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640);
  if (file >= 0 || use == FolderLock::Use::kAlone) return file;
  return open(path.c_str(), O_RDONLY | O_CLOEXEC);
}

// What the user that locked it alone has written there: its process.
std::string owner(int file) {
  std::array<char, 40> text{};
  const ssize_t length = pread(file, text.data(), text.size(), 0);
  return length > 0
             ? " (process " + std::string(text.data(), static_cast<std::size_t>(length)) + ")"
             : "";
}

// Locks bytes of the file; a length of 0 is all of them. The lock is that of the open file, not of
// the process: a second estimator in this process does not have it.
bool is_locked(int file, short type, off_t start, off_t length) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = start;
  lock.l_len = length;
  return fcntl(file, F_OFD_SETLK, &lock) == 0;
}

// For the error of others. A file that cannot be written, on a full disk say, is no matter.
void write_owner(int file, FolderLock::Use use) {
  const std::string process = use == FolderLock::Use::kAlone ? std::to_string(getpid()) : "";
  if (ftruncate(file, 0) == 0 && pwrite(file, process.data(), process.size(), 0) >= 0) return;
}

}  // namespace

FolderLock::~FolderLock() {
  if (file_ < 0) return;
  write_owner(file_, Use::kShared);
  close(file_);
}

bool FolderLock::take(const std::string& folder, Use use) {
  if (held()) return true;
  const int file = opened(folder + "/lock", use);
  if (file < 0) return false;
  const bool alone = use == Use::kAlone;
  const bool locked = alone ? is_locked(file, F_WRLCK, 0, 0) : is_locked(file, F_RDLCK, 0, 1);
  if (!locked) {
    const bool taken = errno == EAGAIN || errno == EACCES;
    const std::string whose = owner(file);
    close(file);
    if (!taken) return false;  // a file system without locks
    throw FileError(folder + ": is in use by another estimator" + whose +
                    ": stop it, or give this one a folder of its own (state.directory); only users "
                    "with state.map read_only share one");
  }
  file_ = file;
  first_ = alone || is_locked(file, F_WRLCK, 1, 1);
  write_owner(file, use);
  return true;
}

}  // namespace gprodom
