#include "io/tum.h"

#include <array>
#include <cstdio>

namespace gprodom {

TumWriter::TumWriter(const std::string& path) : file_(path), stream_(file_.working_path()) {
  if (!stream_) fail(path, "cannot be written");
  stream_ << "# time x y z qx qy qz qw\n";
}

void TumWriter::write(const OdometryEstimate& pose) {
  const Eigen::Vector3d& p = pose.p_odom_body;
  const Eigen::Quaterniond& q = pose.q_odom_body;
  std::array<char, 256> line;
  // In integers, since a double holds seconds since 1970 to 0.2 us only.
  const int length = std::snprintf(
      line.data(), line.size(), "%lld.%09lld %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n",
      static_cast<long long>(pose.time / kSecond), static_cast<long long>(pose.time % kSecond),
      p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
  stream_.write(line.data(), length);
}

void TumWriter::close() {
  stream_.close();
  if (!stream_) fail(file_.path(), "cannot be written");
  file_.put_in_place();
}

}  // namespace gprodom
