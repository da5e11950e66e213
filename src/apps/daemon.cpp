#include "apps/daemon.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <systemd/sd-daemon.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <random>
#include <utility>

#include "base/text.h"
#include "gprodom/odometry.h"
#include "gprodom/version.h"

namespace gprodom {
namespace {

// Pause after LCM has failed to receive.
constexpr std::chrono::milliseconds kReceiveAgain(100);

// The level as a prefix for the journal, which adds times itself.
class JournalLevel : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string_view prefix = message.level >= spdlog::level::err    ? SD_ERR
                                    : message.level == spdlog::level::warn ? SD_WARNING
                                    : message.level == spdlog::level::info ? SD_INFO
                                                                           : SD_DEBUG;
    line.append(prefix.data(), prefix.data() + prefix.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JournalLevel>();
  }
};

std::unique_ptr<spdlog::formatter> make_formatter() {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  if (stderr_is_journal()) {
    formatter->add_flag<JournalLevel>('*').set_pattern("%*%v");
  } else {
    formatter->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
  }
  return formatter;
}

std::shared_ptr<spdlog::logger> make_log(const LoggingConfig& config) {
  auto log = std::make_shared<spdlog::logger>(
      "gprodomd", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  log->set_formatter(make_formatter());
  log->set_level(spdlog::level::from_str(name_of(config.level)));
  log->flush_on(spdlog::level::trace);
  return log;
}

// Keys that do not need a restart of the estimator.
bool applies_while_running(const ConfigChange& change) {
  return change.key.rfind("logging.", 0) == 0;
}

// A random number, the same as another process's with a probability of 2^-48. Exact in a double.
double new_instance() {
  std::random_device random;
  std::uniform_int_distribution<std::int64_t> numbers(1, std::int64_t{1} << 48);
  return static_cast<double>(numbers(random));
}

}  // namespace

void check_consistency(Config config) {
  config.state.directory.clear();
  const Odometry consistent(config);
}

Daemon::Daemon(DaemonOptions options)
    : options_(std::move(options)),
      signals_({SIGINT, SIGTERM, SIGHUP}),
      config_(load_config(options_.config_paths, options_.overrides, &notices_)),
      log_(make_log(config_.logging)),
      instance_(new_instance()),
      link_(options_.lcm_url),
      live_(make_live(config_)) {}

Daemon::~Daemon() { stop(); }

std::unique_ptr<Live> Daemon::make_live(const Config& config) {
  LiveOptions options;
  options.alive = [this] { service_.alive(); };
  options.instance = instance_;
  return std::make_unique<Live>(
      config,
      [this, channels = config.channels](const Outputs& outputs) { publish(channels, outputs); },
      std::move(options));
}

// Of the configuration.
void Daemon::log_notices() {
  for (const std::string& notice : std::exchange(notices_, {})) log_->info(notice);
}

void Daemon::run() {
  log_notices();
  start();
  log_->info("gprodomd {} runs: config {}, LCM {}", kVersion, joined(options_.config_paths, ", "),
             options_.lcm_url);
  Service::tell("READY=1");
  while (signals_.wait() == SIGHUP) {
    Service::tell("RELOADING=1");
    reread_config();
    Service::tell("READY=1");
  }
  Service::tell("STOPPING=1");
  log_->info("stopping");
  stop();
  log_->info("stopped");
}

void Daemon::start() {
  link_.subscribe(
      config_.channels, [live = live_.get()](Input input) { live->push(std::move(input)); },
      [live = live_.get()](double instance) { live->heard_status(instance); });
  receiving_ = true;
  receiver_ = std::thread([this] {
    while (receiving_) {
      if (!link_.receive()) std::this_thread::sleep_for(kReceiveAgain);
    }
  });
}

// In the direction of the data, so that each station works off what it has.
void Daemon::stop() {
  receiving_ = false;
  if (receiver_.joinable()) receiver_.join();
  link_.unsubscribe();
  live_->stop();
}

void Daemon::reread_config() {
  Config config;
  std::vector<ConfigChange> changes;
  bool restarts = false;
  try {
    config = load_config(options_.config_paths, options_.overrides, &notices_);
    changes = differences(config_, config);
    restarts = !std::all_of(changes.begin(), changes.end(), applies_while_running);
    if (restarts) check_consistency(config);
  } catch (const std::exception& error) {  // whatever it is, the old one runs
    log_->error("config not applied, the old one stays: {}", error.what());
    return;
  }
  const auto level = spdlog::level::from_str(name_of(config.logging.level));
  log_notices();
  log_->set_level(std::min(level, log_->level()));  // so that the change of level shows
  log_->info("config reread: {} keys changed", changes.size());
  for (const auto& c : changes) log_->info("config: {}: {} -> {}", c.key, c.before, c.after);
  log_->set_level(level);
  const Config before = std::exchange(config_, config);
  if (restarts) restart(before);
}

// The old estimator saves what it has and ends before the new one reads it. If the new one cannot
// start all the same (its state.directory is in use, say), the old configuration goes on.
void Daemon::restart(const Config& before) {
  log_->warn("the estimator restarts with the new config");
  stop();
  live_.reset();
  try {
    live_ = make_live(config_);
  } catch (const std::exception& error) {
    log_->error("config not applied, the old one goes on: {}", error.what());
    config_ = before;
    live_ = make_live(config_);
  }
  start();
}

void Daemon::publish(const ChannelConfig& channels, const Outputs& outputs) {
  link_.publish(make_messages(channels, outputs));
  for (const auto& warning : outputs.warnings) log_->warn(warning);
  for (const auto& status : outputs.status) log_health(status);
}

void Daemon::log_health(const Status& status) {
  if (status.health == health_) return;
  health_ = status.health;
  const bool ok = health_ == HealthLevel::kOk;
  const std::string text =
      "health: " + name_of(health_) + (ok ? "" : ": " + joined(status.reasons, "; "));
  log_->log(ok                                  ? spdlog::level::info
            : health_ == HealthLevel::kDegraded ? spdlog::level::warn
                                                : spdlog::level::err,
            text);
  Service::tell("STATUS=" + text);
}

}  // namespace gprodom
