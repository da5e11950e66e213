#include "persist/state_store.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/atomic_file.h"
#include "base/text.h"
#include "estimation/drive_traits.h"
#include "gprodom/error.h"
#include "map/ground_map_file.h"

namespace gprodom {
namespace {

// Standard deviation of the change of the scale between two runs: tyres warm up and lose air.
constexpr double kBetweenRuns = 1e-3;
constexpr double kHeld = 1e-7;  // standard deviation of a scale that is held, as at the start

// Largest difference between a saved scale and the configured prior, in its standard deviations. By
// chance one in 16,000 is larger, so the scale is that of another wheel, or the prior is wrong.
constexpr double kMostSigmas = 4.0;

// Times state.save_period. The ground of an hour is some 10 MB. What is new since that was written
// is at most 6 kB a metre, and is written again each time: at 1 m/s both are below 0.1 MB/s
// (bench/map_saving.py).
constexpr double kGroundEvery = 300.0;
constexpr double kNewestEvery = 10.0;

const char* const kWheelFile = "/wheel.state";
const char* const kSlipFile = "/slip.state";
const char* const kPairFile = "/wheels.state";
const char* const kMountingFile = "/imu.state";
const char* const kStateFile = "/pose.state";

const char* const kOtherWheel =
    "wheel.scale or the wheel's mounting was changed in the configuration since";

}  // namespace

// The content of a file, parsed; nothing if the file is missing, or (with a notice) if it cannot be
// used.
template <typename Saved>
std::optional<Saved> StateStore::read(const std::string& path, std::vector<std::string>& notices,
                                      Saved (*parse)(const std::string&, std::string_view)) const {
  if (!keeps_state()) return std::nullopt;
  std::string bytes;
  try {
    if (read_whole(path, bytes)) return parse(path, bytes);
  } catch (const FileError& error) {
    notices.emplace_back(error.what());
  }
  return std::nullopt;
}

StateStore::StateStore(const Config& config)
    : config_(config),
      wheel_setting_(gprodom::wheel_setting(config)),
      directory_(config.state.directory),
      state_period_(from_seconds(config.state.save_period)),
      ground_period_(from_seconds(kGroundEvery * config.state.save_period)),
      newest_period_(from_seconds(kNewestEvery * config.state.save_period)) {
  if (!enabled()) return;
  lock_.take(directory_, writes_ground() ? FolderLock::Use::kAlone : FolderLock::Use::kShared);
  if (keeps_state()) remove_abandoned(directory_);
}

bool StateStore::is_locked() {
  try {
    lock_.take(directory_, writes_ground() ? FolderLock::Use::kAlone : FolderLock::Use::kShared);
    failing_.erase(directory_);
    return true;
  } catch (const FileError& error) {
    failing_[directory_] = error.what();
    return false;
  }
}

Config StateStore::config_with_wheel_scale(std::vector<std::string>& notices) const {
  if (enabled() && !keeps_state())
    notices.push_back(directory_ + ": shared: another user keeps pose, wheel and slip there");
  if (config_.wheel.scale_sigma <= 0) return config_;
  const std::string path = directory_ + kWheelFile;
  const auto wheel = read(path, notices, saved_wheel_from);
  if (!wheel) return config_;
  const std::string reason = why_not(*wheel);
  if (!reason.empty()) {
    notices.push_back(path + ": not used: " + reason);
    return config_;
  }
  Config config = config_;
  config.wheel.scale_sigma = std::hypot(wheel->sigma, kBetweenRuns);
  if (config.wheel.scale_sigma >= config_.wheel.scale_sigma) return config_;
  config.wheel.scale = wheel->scale;
  notices.push_back(formatted("wheel scale of the last run taken up: %.5f +- %.5f",
                              config.wheel.scale, config.wheel.scale_sigma));
  return config;
}

// Why the saved scale cannot be that of the configured wheel; empty if it can.
std::string StateStore::why_not(const SavedWheel& wheel) const {
  if (wheel.setting != wheel_setting_) return kOtherWheel;
  const double sigma = std::hypot(wheel.sigma, config_.wheel.scale_sigma);
  const double sigmas = std::abs(wheel.scale - config_.wheel.scale) / sigma;
  if (sigmas <= kMostSigmas) return "";
  return formatted("its scale %.5f is %.0f standard deviations off wheel.scale (wheel.scale_sigma)",
                   wheel.scale, sigmas);
}

std::optional<slip::Learnt> StateStore::slip(std::vector<std::string>& notices) const {
  const std::string path = directory_ + kSlipFile;
  const auto slip = read(path, notices, saved_slip_from);
  if (!slip) return std::nullopt;
  if (slip->setting == wheel_setting_) return slip->learnt;
  notices.push_back(path + ": not used: " + kOtherWheel);
  return std::nullopt;
}

std::optional<LearntTurn> StateStore::pair(std::vector<std::string>& notices) const {
  const std::string path = directory_ + kPairFile;
  const auto pair = read(path, notices, saved_pair_from);
  if (!pair) return std::nullopt;
  const std::string reason = why_not(*pair);
  notices.push_back(reason.empty()
                        ? formatted("left and right wheels in the last run: track %.4f +- %.4f m",
                                    pair->learnt.track_m, pair->learnt.track_sigma_m)
                        : path + ": not used: " + reason);
  return reason.empty() ? std::optional(pair->learnt) : std::nullopt;
}

std::optional<LearntMounting> StateStore::mounting(std::vector<std::string>& notices) const {
  if (config_.imu.rpy_body_imu.rpy) return std::nullopt;
  return read(directory_ + kMountingFile, notices, saved_mounting_from);
}

// Why it cannot be that of the configured pair; empty if it can.
std::string StateStore::why_not(const SavedPair& pair) const {
  if (pair.setting != pair_setting(config_))
    return "channels.wheels, wheel.drive or wheel.track was changed in the configuration since";
  const DriveTraits expected = drive_traits(config_.wheel);
  const double sigma = std::hypot(pair.learnt.track_sigma_m, expected.track_sigma_m);
  const double sigmas = std::abs(pair.learnt.track_m - expected.track_m) / sigma;
  if (sigmas <= kMostSigmas) return "";
  return formatted(
      "its track of %.3f m is %.0f standard deviations off what wheel.drive and wheel.track let "
      "expect",
      pair.learnt.track_m, sigmas);
}

std::optional<SavedState> StateStore::state(std::vector<std::string>& notices) const {
  auto saved = read(directory_ + kStateFile, notices, saved_state_from);
  if (!saved || saved->wheel_setting == wheel_setting_) return saved;
  saved->state.wheel_scale = config_.wheel.scale;
  saved->covariance.row(row::kScale).setZero();
  saved->covariance.col(row::kScale).setZero();
  saved->covariance(row::kScale, row::kScale) =
      std::pow(std::max(config_.wheel.scale_sigma, kHeld), 2);
  return saved;
}

std::optional<GroundMap> StateStore::ground(const gpr::TraceMemoryOptions& options,
                                            std::vector<std::string>& notices) const {
  if (!enabled()) return std::nullopt;
  try {
    return read_ground_map(ground_path(), options, notices);
  } catch (const FileError& error) {
    notices.emplace_back(error.what());
    return std::nullopt;
  }
}

void StateStore::use_ground_of(const TraceFormat& format) {
  use_main_ground();
  other_format_.clear();
  std::optional<GroundHead> main;
  try {
    main = ground_files_.head(ground_path());
  } catch (const FileError&) {  // what cannot be used is set aside when it is replaced
  }
  if (!main || !main->has_ground || same_format(main->format, format)) return;
  ground_name_ =
      formatted("%s-%zux%gps", kMainGround, format.samples, 1e12 * format.sample_interval_s);
  other_format_ = "the radar sends " + text_of(format) + ", ground.map is of " +
                  text_of(main->format) + ": it stays as it is, and new ground goes to " +
                  ground_name_ + ".map; set the radar back, or command load_map " + ground_name_ +
                  " to go on with that one";
}

bool StateStore::is_due(TimeNs now, TimeNs period, TimeNs& last) const {
  if (!enabled()) return false;
  if (last == 0 || now < last) last = now;  // the first, or the clock was set back
  if (now - last < period) return false;
  last = now;
  return true;
}

template <typename Saved>
void StateStore::write(const char* file, const Saved& saved) {
  if (keeps_state() && is_locked()) writer_.write(directory_ + file, to_bytes(saved));
}

void StateStore::save(const OdometryEstimate& estimate, const std::optional<SavedState>& state) {
  if (estimate.wheel_scale_sigma > 0)
    write(kWheelFile, SavedWheel{estimate.wheel_scale, estimate.wheel_scale_sigma, wheel_setting_});
  if (!state) return;
  SavedState saved = *state;
  saved.wheel_setting = wheel_setting_;
  write(kStateFile, saved);
}

void StateStore::save(const LearntTurn& pair) {
  write(kPairFile, SavedPair{pair, pair_setting(config_)});
}

void StateStore::save(const slip::Learnt& slip) {
  if (slip.counts.rolled_s > 0) write(kSlipFile, SavedSlip{slip, wheel_setting_});
}

void StateStore::save(const LearntMounting& mounting) { write(kMountingFile, mounting); }

void StateStore::save_ground(const std::string& path, SavedGround ground, bool asked) {
  if (!asked && ground.empty) return;
  const auto kept = std::make_shared<const SavedGround>(std::move(ground));
  if (kept->base != 0) {
    writer_.run(newest_of(path), [this, path, kept] {
      FileWriter::Report report;
      report.done = ground_files_.add_newest(path, *kept, report.told);
      return report;
    });
    return;
  }
  writer_.run(path, [this, path, kept, asked] {
    FileWriter::Report report;
    if (!ground_files_.replace(path, *kept, report.told) && asked)
      throw FileError(path + ": not saved: no ground is stored yet, and the file holds some");
    return report;
  });
}

std::vector<std::string> StateStore::take_notices() {
  std::vector<std::string> notices;
  for (const auto& [path, error, report] : writer_.take_outcomes()) {
    needs_whole_ = needs_whole_ || !report.done;
    tell(report.told, notices);
    failing_.erase(path);
    if (!error.empty()) failing_[path] = error;
    const auto asked = std::find(awaited_.begin(), awaited_.end(), path);
    if (asked == awaited_.end()) continue;
    awaited_.erase(asked);
    notices.push_back(error.empty() ? path + ": saved" : error);
  }
  return notices;
}

void StateStore::tell(const std::vector<std::string>& told, std::vector<std::string>& notices) {
  if (told.empty()) return;
  kept_aside_ = told.back();
  notices.insert(notices.end(), told.begin(), told.end());
}

std::string StateStore::trouble() const {
  std::vector<std::string> errors;
  for (const auto& [path, error] : failing_) errors.push_back(error);
  return joined(errors, "; ");
}

}  // namespace gprodom
