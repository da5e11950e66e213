#include "persist/saved_state.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "base/sealed_bytes.h"

namespace gprodom {
namespace {

const char* const kStateTitle = "gprodom state 4";

void get_rotation(ByteReader& in, Eigen::Quaterniond& q) {
  in.get_all(q.coeffs());
  if (!(std::abs(q.norm() - 1.0) < 1e-6)) in.refuse("a rotation is not of unit length");
  q.normalize();
}

}  // namespace

std::string to_bytes(const SavedState& saved) {
  ByteWriter out;
  const NavState& x = saved.state;
  out.put(x.time);
  out.put_all(x.q_odom_body.coeffs());
  for (const auto* vector : {&x.p_odom, &x.v_odom, &x.gyro_bias, &x.accel_bias})
    out.put_all(*vector);
  out.put(x.wheel_scale);
  out.put_all(saved.covariance);
  out.put(saved.noise.gyro_density);
  out.put(saved.noise.accel_density);
  out.put(saved.accel_scale);
  out.put(static_cast<std::uint8_t>(saved.wheel_m.has_value()));
  out.put(saved.wheel_m.value_or(0.0));
  out.put(saved.distance_m);
  out.put(static_cast<std::uint8_t>(saved.correction.has_value()));
  const Correction correction = saved.correction.value_or(Correction{});
  out.put_all(correction.q_map_odom.coeffs());
  out.put_all(correction.p_map_odom);
  out.put_all(correction.covariance);
  out.put(static_cast<std::int32_t>(correction.revisits));
  out.put(static_cast<std::int32_t>(saved.map));
  out.put_text(saved.wheel_setting);
  out.put(saved.ground);
  return out.sealed(kStateTitle);
}

SavedState saved_state_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kStateTitle);
  SavedState saved;
  NavState& x = saved.state;
  x.time = in.get<TimeNs>();
  get_rotation(in, x.q_odom_body);
  for (auto* vector : {&x.p_odom, &x.v_odom, &x.gyro_bias, &x.accel_bias}) in.get_all(*vector);
  x.wheel_scale = in.get<double>();
  in.get_all(saved.covariance);
  saved.noise.gyro_density = in.get<double>();
  saved.noise.accel_density = in.get<double>();
  saved.accel_scale = in.get<double>();
  const bool has_wheel = in.get<std::uint8_t>() != 0;
  const auto wheel_m = in.get<double>();
  if (has_wheel) saved.wheel_m = wheel_m;
  saved.distance_m = in.get<double>();
  const bool has_correction = in.get<std::uint8_t>() != 0;
  Correction correction;
  get_rotation(in, correction.q_map_odom);
  in.get_all(correction.p_map_odom);
  in.get_all(correction.covariance);
  correction.revisits = in.get<std::int32_t>();
  if (has_correction) saved.correction = correction;
  saved.map = in.get<std::int32_t>();
  saved.wheel_setting = in.get_text();
  saved.ground = in.get<std::uint64_t>();
  in.expect_end();
  const bool sound =
      x.finite() && x.wheel_scale > 0 && saved.noise.gyro_density > 0 &&
      saved.noise.accel_density > 0 && saved.accel_scale > 0 && std::isfinite(saved.accel_scale) &&
      std::isfinite(wheel_m) && std::isfinite(saved.distance_m) && saved.covariance.allFinite() &&
      saved.covariance.llt().info() == Eigen::Success && correction.p_map_odom.allFinite() &&
      correction.covariance.allFinite() && saved.map >= 0;
  if (!sound) in.refuse("a figure of it is out of range");
  return saved;
}

}  // namespace gprodom
