#include "io/tum.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "gprodom/error.h"

namespace gprodom {
namespace {

[[noreturn]] void cannot_write(const std::string& path) {
  throw FileError(path + ": cannot be written: " + std::strerror(errno));
}

}  // namespace

TumWriter::TumWriter(const std::string& path) : file_(path), stream_(file_.working_path()) {
  if (!stream_) cannot_write(path);
  stream_ << "# time x y z qx qy qz qw\n";
}

void TumWriter::write(TimeNs time, const Eigen::Vector3d& p, const Eigen::Quaterniond& q) {
  std::array<char, 256> line;
  // In integers, since a double holds seconds since 1970 to 0.2 us only.
  const int length = std::snprintf(
      line.data(), line.size(), "%lld.%09lld %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n",
      static_cast<long long>(time / kSecond), static_cast<long long>(time % kSecond), p.x(), p.y(),
      p.z(), q.x(), q.y(), q.z(), q.w());
  stream_.write(line.data(), length);
}

void TumWriter::close() {
  stream_.close();
  if (!stream_) cannot_write(file_.path());
  file_.put_in_place();
}

}  // namespace gprodom
