#include "base/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <utility>

#include "gprodom/error.h"

namespace gprodom {
namespace {

namespace fs = std::filesystem;

const char* const kEnding = ".part";

bool is_special(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode);
}

// The process id in the name of a temporary file, which ends in .PROCESS.part; 0 for other files.
pid_t owner_of(const fs::path& file) {
  if (file.extension() != kEnding) return 0;
  const std::string number = file.stem().extension().string();  // with its dot
  return number.size() > 1 ? static_cast<pid_t>(std::atoi(number.c_str() + 1)) : 0;
}

// Of a file; the working folder is "." to others.
std::string folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path().string() : ".";
}

// Synchronises a file or a folder to disk; errno is then that of fsync(). EINVAL counts as
// success: the file system does not support it, and nothing better can be done. So does a folder
// that can be written but not listed, which cannot be opened.
bool is_forced(const std::string& path, bool is_folder) {
  const int opened = open(path.c_str(), O_RDONLY | O_CLOEXEC | (is_folder ? O_DIRECTORY : 0));
  if (opened < 0) return is_folder;
  const bool forced = fsync(opened) == 0 || errno == EINVAL;
  const int error = errno;
  close(opened);
  errno = error;
  return forced;
}

}  // namespace

void fail(const std::string& path, const std::string& what) {
  throw FileError(path + ": " + what + ": " + std::strerror(errno));
}

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  in_place_ = is_special(path_);
  working_path_ = in_place_ ? path_ : path_ + "." + std::to_string(getpid()) + kEnding;
}

AtomicFile::~AtomicFile() {
  if (!in_place_) std::remove(working_path_.c_str());
}

void AtomicFile::put_in_place() {
  if (in_place_) return;
  if (!is_forced(working_path_, false)) fail(path_, "cannot be written");
  if (std::rename(working_path_.c_str(), path_.c_str()) != 0) fail(path_, "cannot be put in place");
  in_place_ = true;
  if (!is_forced(folder_of(path_), true)) fail(path_, "cannot be put in place for good");
}

void write_whole(const std::string& path, const std::string& bytes) {
  AtomicFile file(path);
  std::ofstream stream(file.working_path(), std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) fail(path, "cannot be written");
  file.put_in_place();
}

bool read_whole(const std::string& path, std::string& bytes) {
  std::error_code error;
  if (!fs::exists(path, error)) return false;
  if (fs::is_directory(path, error)) throw FileError(path + ": cannot be read: it is a folder");
  std::ifstream file(path, std::ios::binary);
  try {
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  } catch (const std::ios_base::failure&) {  // of the stream's buffer, which a failing disk makes
    file.setstate(std::ios::badbit);
  }
  if (!file.is_open() || file.bad()) throw FileError(path + ": cannot be read");
  return true;
}

std::string set_aside(const std::string& path, bool keep_both) {
  struct stat file {};
  if (stat(path.c_str(), &file) != 0) return {};
  const fs::path whole(path);
  const std::string ending = whole.extension().string();
  // Numbers that a file has, of whatever ending: what belongs together has one number.
  std::set<std::string> taken;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder_of(whole), ignored))
    taken.insert(entry.path().stem().string());
  int number = 1;
  const auto stem = [&] { return whole.stem().string() + ".kept-" + std::to_string(number); };
  const auto name = [&] { return (whole.parent_path() / (stem() + ending)).string(); };
  struct stat other {};
  for (; taken.count(stem()) > 0 || lstat(name().c_str(), &other) == 0; ++number)
    if (keep_both && lstat(name().c_str(), &other) == 0 && other.st_dev == file.st_dev &&
        other.st_ino == file.st_ino)
      return name();
  std::string kept = name();
  const bool linked = keep_both && link(path.c_str(), kept.c_str()) == 0;
  if (!linked && std::rename(path.c_str(), kept.c_str()) != 0) fail(path, "cannot be set aside");
  if (!is_forced(folder_of(path), true)) fail(path, "cannot be set aside for good");
  return kept;
}

void remove_abandoned(const std::string& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const pid_t owner = owner_of(entry.path());
    if (owner > 0 && kill(owner, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), ignored);
  }
}

}  // namespace gprodom
