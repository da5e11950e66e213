#include "persist/learnt.h"

#include <cmath>
#include <initializer_list>
#include <iomanip>
#include <limits>
#include <sstream>

#include "base/sealed_bytes.h"

namespace gprodom {
namespace {

const char* const kWheelTitle = "gprodom wheel 1";
const char* const kSlipTitle = "gprodom slip 2";
const char* const kPairTitle = "gprodom wheels 1";
const char* const kMountingTitle = "gprodom mounting 1";

// A setting as text, every digit of its figures.
std::ostringstream setting_text() {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10);
  return text;
}

bool is_sigma(double value) { return value > 0 && std::isfinite(value); }

// setting: null where there is none.
std::string sealed(const char* title, std::initializer_list<double> figures,
                   const std::string* setting) {
  ByteWriter out;
  for (const double figure : figures) out.put(figure);
  if (setting) out.put_text(*setting);
  return out.sealed(title);
}

// The same in reverse. is_sound(): of the figures that were read.
template <typename IsSound>
void unseal(const std::string& name, std::string_view bytes, const char* title,
            std::initializer_list<double*> figures, std::string* setting, IsSound is_sound) {
  ByteReader in(name, bytes, title);
  for (double* figure : figures) *figure = in.get<double>();
  if (setting) *setting = in.get_text();
  in.expect_end();
  if (!is_sound()) in.refuse("a figure of it is out of range");
}

}  // namespace

std::string wheel_setting(const Config& config) {
  std::ostringstream text = setting_text();
  text << config.channels.wheel << "; " << config.channels.wheels << "; "
       << name_of(config.wheel.form) << "; " << config.wheel.scale << "; "
       << config.wheel.lever_arm.transpose();
  return text.str();
}

std::string pair_setting(const Config& config) {
  std::ostringstream text = setting_text();
  text << config.channels.wheels << "; " << name_of(config.wheel.drive) << "; "
       << config.wheel.track;
  return text.str();
}

std::string to_bytes(const SavedWheel& wheel) {
  return sealed(kWheelTitle, {wheel.scale, wheel.sigma}, &wheel.setting);
}

SavedWheel saved_wheel_from(const std::string& name, std::string_view bytes) {
  SavedWheel wheel;
  unseal(name, bytes, kWheelTitle, {&wheel.scale, &wheel.sigma}, &wheel.setting,
         [&] { return wheel.scale >= 0.1 && wheel.scale <= 10 && is_sigma(wheel.sigma); });
  return wheel;
}

std::string to_bytes(const SavedSlip& slip) {
  const auto& [counts, position] = slip.learnt;
  return sealed(kSlipTitle, {counts.rolled_s, counts.slipped_s, position.y_m, position.sigma_m},
                &slip.setting);
}

SavedSlip saved_slip_from(const std::string& name, std::string_view bytes) {
  SavedSlip slip;
  auto& counts = slip.learnt.counts;
  auto& position = slip.learnt.position;
  unseal(name, bytes, kSlipTitle,
         {&counts.rolled_s, &counts.slipped_s, &position.y_m, &position.sigma_m}, &slip.setting,
         [&] {
           return std::isfinite(counts.rolled_s) && counts.slipped_s >= 0 &&
                  counts.slipped_s <= counts.rolled_s && std::isfinite(position.y_m) &&
                  std::isfinite(position.sigma_m) && position.sigma_m >= 0;
         });
  return slip;
}

std::string to_bytes(const SavedPair& pair) {
  const LearntTurn& learnt = pair.learnt;
  return sealed(kPairTitle,
                {learnt.track_m, learnt.track_sigma_m, learnt.radii_difference,
                 learnt.radii_difference_sigma},
                &pair.setting);
}

SavedPair saved_pair_from(const std::string& name, std::string_view bytes) {
  SavedPair pair;
  LearntTurn& learnt = pair.learnt;
  unseal(name, bytes, kPairTitle,
         {&learnt.track_m, &learnt.track_sigma_m, &learnt.radii_difference,
          &learnt.radii_difference_sigma},
         &pair.setting, [&] {
           return learnt.track_m > 0 && std::isfinite(learnt.track_m) &&
                  is_sigma(learnt.track_sigma_m) && std::abs(learnt.radii_difference) < 1 &&
                  is_sigma(learnt.radii_difference_sigma);
         });
  return pair;
}

std::string to_bytes(const LearntMounting& mounting) {
  const Eigen::Quaterniond& q = mounting.q_body_imu;
  return sealed(kMountingTitle, {q.w(), q.x(), q.y(), q.z(), mounting.yaw_sigma}, nullptr);
}

LearntMounting saved_mounting_from(const std::string& name, std::string_view bytes) {
  LearntMounting mounting;
  Eigen::Quaterniond& q = mounting.q_body_imu;
  unseal(name, bytes, kMountingTitle, {&q.w(), &q.x(), &q.y(), &q.z(), &mounting.yaw_sigma},
         nullptr, [&] {
           return std::abs(q.norm() - 1) < 1e-6 && mounting.yaw_sigma > 0 &&
                  mounting.yaw_sigma < M_PI;
         });
  return mounting;
}

}  // namespace gprodom
