#include "persist/saved_wheel.h"

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "base/sealed_bytes.h"

namespace gprodom {
namespace {

const char* const kWheelTitle = "gprodom wheel 1";
const char* const kSlipTitle = "gprodom slip 2";
const char* const kPairTitle = "gprodom wheels 1";

// A setting as text, every digit of its figures.
std::ostringstream setting_text() {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10);
  return text;
}

bool is_sigma(double value) { return value > 0 && std::isfinite(value); }

}  // namespace

std::string wheel_setting(const Config& config) {
  std::ostringstream text = setting_text();
  text << config.channels.wheel << "; " << config.channels.wheels << "; "
       << name_of(config.wheel.form) << "; " << config.wheel.scale << "; "
       << config.wheel.lever_arm.transpose();
  return text.str();
}

std::string to_bytes(const SavedWheel& wheel) {
  ByteWriter out;
  out.put(wheel.scale);
  out.put(wheel.sigma);
  out.put_text(wheel.setting);
  return out.sealed(kWheelTitle);
}

SavedWheel saved_wheel_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kWheelTitle);
  SavedWheel wheel;
  wheel.scale = in.get<double>();
  wheel.sigma = in.get<double>();
  wheel.setting = in.get_text();
  in.expect_end();
  if (!(wheel.scale >= 0.1 && wheel.scale <= 10 && is_sigma(wheel.sigma)))
    in.refuse("a figure of it is out of range");
  return wheel;
}

std::string to_bytes(const SavedSlip& slip) {
  ByteWriter out;
  const auto& [counts, position] = slip.learnt;
  for (const double figure : {counts.rolled_s, counts.slipped_s, position.y_m, position.sigma_m})
    out.put(figure);
  out.put_text(slip.setting);
  return out.sealed(kSlipTitle);
}

SavedSlip saved_slip_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kSlipTitle);
  SavedSlip slip;
  auto& [counts, position] = slip.learnt;
  for (double* figure : {&counts.rolled_s, &counts.slipped_s, &position.y_m, &position.sigma_m})
    *figure = in.get<double>();
  slip.setting = in.get_text();
  in.expect_end();
  const bool sound = std::isfinite(counts.rolled_s) && counts.slipped_s >= 0 &&
                     counts.slipped_s <= counts.rolled_s && std::isfinite(position.y_m) &&
                     std::isfinite(position.sigma_m) && position.sigma_m >= 0;
  if (!sound) in.refuse("a figure of it is out of range");
  return slip;
}

std::string pair_setting(const Config& config) {
  std::ostringstream text = setting_text();
  text << config.channels.wheels << "; " << name_of(config.wheel.drive) << "; "
       << config.wheel.track;
  return text.str();
}

std::string to_bytes(const SavedPair& pair) {
  const LearntTurn& learnt = pair.learnt;
  ByteWriter out;
  for (const double figure : {learnt.track_m, learnt.track_sigma_m, learnt.radii_difference,
                              learnt.radii_difference_sigma})
    out.put(figure);
  out.put_text(pair.setting);
  return out.sealed(kPairTitle);
}

SavedPair saved_pair_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kPairTitle);
  SavedPair pair;
  LearntTurn& learnt = pair.learnt;
  for (double* figure : {&learnt.track_m, &learnt.track_sigma_m, &learnt.radii_difference,
                         &learnt.radii_difference_sigma})
    *figure = in.get<double>();
  pair.setting = in.get_text();
  in.expect_end();
  const bool sound = learnt.track_m > 0 && std::isfinite(learnt.track_m) &&
                     is_sigma(learnt.track_sigma_m) && std::abs(learnt.radii_difference) < 1 &&
                     is_sigma(learnt.radii_difference_sigma);
  if (!sound) in.refuse("a figure of it is out of range");
  return pair;
}

}  // namespace gprodom
