#include "persist/saved_wheel.h"

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "base/sealed_bytes.h"

namespace gprodom {
namespace {

const char* const kTitle = "gprodom wheel 1";

}  // namespace

std::string wheel_setting(const Config& config) {
  std::ostringstream text;
  text << std::setprecision(std::numeric_limits<double>::max_digits10) << config.channels.wheel
       << "; " << name_of(config.wheel.form) << "; " << config.wheel.scale << "; "
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
  const bool sound =
      wheel.scale >= 0.1 && wheel.scale <= 10 && wheel.sigma > 0 && std::isfinite(wheel.sigma);
  if (!sound) in.refuse("a figure of it is out of range");
  return wheel;
}

}  // namespace gprodom
