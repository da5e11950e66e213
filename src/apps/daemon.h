// The daemon: receives messages over LCM, estimates and publishes over LCM, until a signal ends it.
#pragma once

#include <spdlog/logger.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "apps/service.h"
#include "apps/signal_watch.h"
#include "gprodom/config.h"
#include "gprodom/live.h"
#include "io/lcm_link.h"

namespace gprodom {

struct DaemonOptions {
  std::vector<std::string> config_paths;  // later ones override earlier ones
  std::vector<std::string> overrides;
  std::string lcm_url = kDefaultLcmUrl;
};

// Throws ConfigError where settings contradict each other. Reads and writes no file.
void check_consistency(Config config);

class Daemon {
 public:
  // Throws ConfigError, or std::runtime_error if LCM cannot be used.
  explicit Daemon(DaemonOptions options);
  ~Daemon();

  // SIGINT and SIGTERM end it after all estimates are published; SIGHUP rereads the config.
  void run();

 private:
  std::unique_ptr<Live> make_live(const Config& config);
  void start();
  void stop();
  void reread_config();
  void restart(const Config& before);
  void log_notices();
  void publish(const ChannelConfig& channels, const Outputs& outputs);
  void log_health(const Status& status);

  const DaemonOptions options_;
  SignalWatch signals_;                    // before any thread
  Service service_;                        // guards itself
  std::vector<std::string> notices_;       // of the configuration, to be logged; main thread only
  Config config_;                          // main thread only
  std::shared_ptr<spdlog::logger> log_;    // guards itself
  const double instance_;                  // of this process
  HealthLevel health_ = HealthLevel::kOk;  // last logged; publish thread only
  LcmLink link_;                           // guards itself
  std::unique_ptr<Live> live_;             // main thread only
  std::atomic<bool> receiving_{false};     // receiver_ ends when it is false
  std::thread receiver_;                   // receives for link_; main thread only
};

}  // namespace gprodom
