#include "io/output_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "gprodom/error.h"

namespace gprodom {
namespace {

bool is_special(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode);
}

}  // namespace

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  in_place_ = is_special(path_);
  working_path_ = in_place_ ? path_ : path_ + "." + std::to_string(getpid()) + ".part";
}

OutputFile::~OutputFile() {
  if (!in_place_) std::remove(working_path_.c_str());
}

void OutputFile::put_in_place() {
  if (in_place_) return;
  if (std::rename(working_path_.c_str(), path_.c_str()) != 0) {
    throw FileError(path_ + ": cannot be put in place: " + std::strerror(errno));
  }
  in_place_ = true;
}

}  // namespace gprodom
