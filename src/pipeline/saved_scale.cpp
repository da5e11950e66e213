#include "pipeline/saved_scale.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <utility>

namespace gprodom {
namespace {

// Between two runs tyres warm up and lose air: that much more is unknown of the scale.
constexpr double kBetweenRuns = 1e-3;

}  // namespace

SavedScale::SavedScale(const StateConfig& config)
    : path_(config.directory.empty() ? "" : config.directory + "/wheel_scale.txt"),
      period_(from_seconds(config.save_period)) {}

Config SavedScale::taken_up(Config config, std::vector<std::string>& notices) const {
  if (path_.empty() || config.wheel.scale_sigma <= 0) return config;
  std::ifstream file(path_);
  if (!file) return config;
  double scale = 0, sigma = 0;
  file >> scale >> sigma;
  const bool sound = file && std::isfinite(scale) && scale >= 0.1 && scale <= 10 &&
                     std::isfinite(sigma) && sigma > 0;
  if (!sound) {
    notices.push_back(path_ + ": expected scale and standard deviation; it is not used");
    return config;
  }
  sigma = std::hypot(sigma, kBetweenRuns);
  if (sigma >= config.wheel.scale_sigma) return config;
  config.wheel.scale = scale;
  config.wheel.scale_sigma = sigma;
  char text[80];
  std::snprintf(text, sizeof text, "wheel scale of the last run taken up: %.5f +- %.5f", scale,
                sigma);
  notices.emplace_back(text);
  return config;
}

// Written beside and renamed, so that there is a whole file at any time.
std::string SavedScale::save(const OdometryEstimate& newest) {
  if (path_.empty() || newest.wheel_scale_sigma <= 0) return {};
  if (last_ == 0) last_ = newest.time;
  if (newest.time - last_ < period_) return {};
  last_ = newest.time;
  const std::string beside = path_ + ".new";
  std::ofstream file(beside);
  file << std::setprecision(9) << newest.wheel_scale << ' ' << newest.wheel_scale_sigma << '\n';
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(beside, path_, error);
  const bool failed = !file || error;
  if (!failed || std::exchange(failed_, true)) return {};
  return path_ + ": cannot be written; the wheel's scale is not kept for the next run";
}

}  // namespace gprodom
