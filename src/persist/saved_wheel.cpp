#include "persist/saved_wheel.h"

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "base/sealed_bytes.h"

namespace gprodom {
namespace {

const char* const kTitle = "gprodom wheel 1";
const char* const kPositionTitle = "gprodom wheel position 1";
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
  return out.sealed(kTitle);
}

SavedWheel saved_wheel_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kTitle);
  SavedWheel wheel;
  wheel.scale = in.get<double>();
  wheel.sigma = in.get<double>();
  wheel.setting = in.get_text();
  in.expect_end();
  if (!(wheel.scale >= 0.1 && wheel.scale <= 10 && is_sigma(wheel.sigma)))
    in.refuse("a figure of it is out of range");
  return wheel;
}

std::string to_bytes(const SavedPosition& position) {
  ByteWriter out;
  out.put(position.learnt.y_m);
  out.put(position.learnt.sigma_m);
  out.put_text(position.setting);
  return out.sealed(kPositionTitle);
}

SavedPosition saved_position_from(const std::string& name, std::string_view bytes) {
  ByteReader in(name, bytes, kPositionTitle);
  SavedPosition position;
  position.learnt.y_m = in.get<double>();
  position.learnt.sigma_m = in.get<double>();
  position.setting = in.get_text();
  in.expect_end();
  if (!std::isfinite(position.learnt.y_m) || !is_sigma(position.learnt.sigma_m))
    in.refuse("a figure of it is out of range");
  return position;
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
