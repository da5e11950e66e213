#include "persist/state_store.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "base/atomic_file.h"
#include "gprodom/error.h"
#include "map/ground_map_file.h"

namespace gprodom {
namespace {

// Between two runs tyres warm up and lose air: that much more is unknown of the scale.
constexpr double kBetweenRuns = 1e-3;

const char* const kScaleFile = "/wheel_scale.txt";
const char* const kStateFile = "/pose.state";

// The bytes of a file; nothing where it is not there, or cannot be read, which is said.
std::optional<std::string> bytes_of(const std::string& path, std::vector<std::string>& notices) {
  std::string bytes;
  try {
    if (read_whole(path, bytes)) return bytes;
  } catch (const FileError& error) {
    notices.emplace_back(error.what());
  }
  return std::nullopt;
}

}  // namespace

StateStore::StateStore(const StateConfig& config)
    : directory_(config.directory),
      state_period_(from_seconds(config.save_period)),
      ground_period_(from_seconds(config.map_save_period)) {
  if (enabled()) remove_abandoned(directory_);
}

Config StateStore::with_wheel_scale(Config config, std::vector<std::string>& notices) const {
  if (!enabled() || config.wheel.scale_sigma <= 0) return config;
  const std::string path = directory_ + kScaleFile;
  const auto bytes = bytes_of(path, notices);
  if (!bytes) return config;
  std::istringstream text(*bytes);
  double scale = 0, sigma = 0;
  text >> scale >> sigma;
  const bool sound = text && std::isfinite(scale) && scale >= 0.1 && scale <= 10 &&
                     std::isfinite(sigma) && sigma > 0;
  if (!sound) {
    notices.push_back(path + ": expected scale and standard deviation; it is not used");
    return config;
  }
  sigma = std::hypot(sigma, kBetweenRuns);
  if (sigma >= config.wheel.scale_sigma) return config;
  config.wheel.scale = scale;
  config.wheel.scale_sigma = sigma;
  char said[80];
  std::snprintf(said, sizeof said, "wheel scale of the last run taken up: %.5f +- %.5f", scale,
                sigma);
  notices.emplace_back(said);
  return config;
}

std::optional<SavedState> StateStore::state(std::vector<std::string>& notices) const {
  if (!enabled()) return std::nullopt;
  const std::string path = directory_ + kStateFile;
  try {
    if (const auto bytes = bytes_of(path, notices)) return saved_state_from(path, *bytes);
  } catch (const FileError& error) {
    notices.emplace_back(error.what());
  }
  return std::nullopt;
}

std::optional<GroundMap> StateStore::ground(const gpr::TraceMemoryOptions& options,
                                            std::vector<std::string>& notices) const {
  if (!enabled()) return std::nullopt;
  try {
    if (const auto bytes = bytes_of(ground_path(), notices))
      return ground_map_from(ground_path(), *bytes, options);
  } catch (const FileError& error) {
    notices.emplace_back(error.what());
  }
  return std::nullopt;
}

bool StateStore::is_due(TimeNs now, TimeNs period, TimeNs& last) const {
  if (!enabled()) return false;
  if (last == 0 || now < last) last = now;  // the first, or the clock was set back
  if (now - last < period) return false;
  last = now;
  return true;
}

void StateStore::save(const OdometryEstimate& estimate, const std::optional<SavedState>& state) {
  if (!enabled()) return;
  if (estimate.wheel_scale_sigma > 0) {
    char text[80];
    std::snprintf(text, sizeof text, "%.9g %.9g\n", estimate.wheel_scale,
                  estimate.wheel_scale_sigma);
    writer_.write(directory_ + kScaleFile, text);
  }
  if (state) writer_.write(directory_ + kStateFile, to_bytes(*state));
}

std::vector<std::string> StateStore::take_notices() {
  std::vector<std::string> notices;
  for (const auto& [path, error] : writer_.take_outcomes()) {
    if (error.empty()) {
      failing_.erase(path);
    } else {
      failing_[path] = error;
    }
    const auto asked = std::find(awaited_.begin(), awaited_.end(), path);
    if (asked == awaited_.end()) continue;
    awaited_.erase(asked);
    notices.push_back(error.empty() ? path + ": saved" : error);
  }
  return notices;
}

std::string StateStore::trouble() const {
  std::string all;
  for (const auto& [path, error] : failing_) all += (all.empty() ? "" : "; ") + error;
  return all;
}

}  // namespace gprodom
