#include "persist/saved_mounting.h"

#include <cmath>

#include "base/sealed_bytes.h"

namespace gprodom {
namespace {

const char* const kTitle = "gprodom imu 1";

}  // namespace

std::string to_bytes(const SavedMounting& mounting) {
  ByteWriter out;
  out.put_all(mounting.found.rpy_body_imu.data(), 3);
  out.put(mounting.found.yaw_sigma);
  out.put_text(mounting.channel);
  return out.sealed(kTitle);
}

SavedMounting saved_mounting_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kTitle);
  SavedMounting mounting;
  in.get_all(mounting.found.rpy_body_imu.data(), 3);
  mounting.found.yaw_sigma = in.get<double>();
  mounting.channel = in.get_text();
  in.expect_end();
  const double sigma = mounting.found.yaw_sigma;
  if (!mounting.found.rpy_body_imu.allFinite() || !(sigma > 0 && std::isfinite(sigma)))
    in.refuse("a figure of it is out of range");
  return mounting;
}

}  // namespace gprodom
