#include "persist/saved_mounting.h"

#include <cmath>

#include "base/sealed_bytes.h"

namespace gprodom {
namespace {

const char* const kTitle = "gprodom mounting 1";

}  // namespace

std::string to_bytes(const LearntMounting& mounting) {
  ByteWriter out;
  const Eigen::Quaterniond& q = mounting.q_body_imu;
  for (const double figure : {q.w(), q.x(), q.y(), q.z(), mounting.yaw_sigma}) out.put(figure);
  return out.sealed(kTitle);
}

LearntMounting saved_mounting_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kTitle);
  LearntMounting mounting;
  Eigen::Quaterniond& q = mounting.q_body_imu;
  for (double* figure : {&q.w(), &q.x(), &q.y(), &q.z(), &mounting.yaw_sigma})
    *figure = in.get<double>();
  in.expect_end();
  const bool sound =
      std::abs(q.norm() - 1) < 1e-6 && mounting.yaw_sigma > 0 && mounting.yaw_sigma < M_PI;
  if (!sound) in.refuse("a figure of it is out of range");
  return mounting;
}

}  // namespace gprodom
