#include "apps/replay.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include "gprodom/error.h"
#include "gprodom/lcm_io.h"
#include "io/log_io.h"
#include "io/tum.h"
#include "live/runner.h"

namespace gprodom {
namespace {

constexpr long kEventsBetweenHooks = 500;

// The reason why a log gave no pose.
std::string why_none(const ReplayStats& stats, const ChannelConfig& channels) {
  if (stats.read.count(channels.imu) == 0)
    return "the log has no message on channel " + channels.imu + " (channels.imu)";
  for (const auto& reason : stats.last_status.reasons)
    if (reason.rfind("start: ", 0) == 0) return reason;
  return stats.last_status.time > 0 ? "the log ends before the first one"
                                    : "no IMU message could be used";
}

class Replay {
 public:
  Replay(const Config& config, const ReplayFiles& files)
      : channels_(config.channels),
        runner_(config, Execution::kInline),
        reader_(files.input),
        writer_(files.output) {
    if (!files.trajectory.empty()) trajectory_.emplace(files.trajectory);
    if (!files.smoothed.empty()) {
      smoothed_.emplace(files.smoothed);
      runner_.record();
    }
  }

  ReplayStats run(const ReplayHooks& hooks);

 private:
  void read(const lcm::LogEvent& event);
  void write(const Outputs& outputs);

  const ChannelConfig channels_;
  Runner runner_;
  LogReader reader_;
  LogWriter writer_;
  std::optional<TumWriter> trajectory_, smoothed_;
  ReplayStats stats_;
};

ReplayStats Replay::run(const ReplayHooks& hooks) {
  const auto begin = std::chrono::steady_clock::now();
  long events = 0;
  std::int64_t first = 0;
  std::int64_t last = 0;
  while (const lcm::LogEvent* event = reader_.next()) {
    if (events++ == 0) first = event->timestamp;
    last = event->timestamp;
    read(*event);
    if (events % kEventsBetweenHooks == 0) {
      hooks.progress(reader_.progress());
      if (hooks.is_interrupted()) throw std::runtime_error("interrupted; nothing was written");
    }
  }
  write(runner_.finish());
  stats_.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  stats_.timing = runner_.timing();
  if (smoothed_ && stats_.poses > 0) {
    for (const auto& pose : runner_.smoothed(&stats_.antennas)) smoothed_->write(pose);
    smoothed_->close();
  }
  writer_.close();
  if (trajectory_) trajectory_->close();
  stats_.damage = reader_.damage();
  if (stats_.poses == 0) stats_.why_no_pose = why_none(stats_, channels_);
  stats_.log_seconds = static_cast<double>(last - first) * 1e-6;
  return stats_;
}

void Replay::read(const lcm::LogEvent& event) {
  const auto input =
      decode_input(channels_, event.channel, event.data, static_cast<std::size_t>(event.datalen));
  if (!input) {
    ++stats_.unused;
    return;
  }
  ++stats_.read[event.channel];
  if (std::holds_alternative<Rejection>(*input)) ++stats_.refused;
  write(runner_.feed(*input));
}

void Replay::write(const Outputs& outputs) {
  for (const auto& message : make_messages(channels_, outputs)) {
    writer_.write(message);
    ++stats_.published[message.channel];
  }
  if (trajectory_)
    for (const auto& pose : outputs.odometry_in_map) trajectory_->write(pose);
  stats_.poses += static_cast<long>(outputs.odometry_in_map.size());
  stats_.warnings.insert(stats_.warnings.end(), outputs.warnings.begin(), outputs.warnings.end());
  if (!outputs.status.empty()) stats_.last_status = outputs.status.back();
}

// No output may replace a file that is read, by any name or link, nor another output.
void check_distinct(const ReplayFiles& files) {
  namespace fs = std::filesystem;
  std::error_code missing;
  std::vector<std::string> inputs = files.configs, outputs;
  inputs.push_back(files.input);
  for (const auto& output : {files.output, files.trajectory, files.smoothed, files.stats}) {
    if (output.empty()) continue;
    for (const auto& input : inputs)
      if (fs::equivalent(input, output, missing))
        throw FileError(output + ": is an input file; expected another file");
    const bool device = fs::exists(output, missing) && !fs::is_regular_file(output, missing);
    for (const auto& other : outputs)
      if (!device && fs::weakly_canonical(other, missing) == fs::weakly_canonical(output, missing))
        throw FileError(output + ": two outputs in one file; give each its own");
    outputs.push_back(output);
  }
}

}  // namespace

ReplayStats replay(const Config& config, const ReplayFiles& files, const ReplayHooks& hooks) {
  check_distinct(files);
  return Replay(config, files).run(hooks);
}

}  // namespace gprodom
