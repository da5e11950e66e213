// gprodomd: the odometry daemon.
#include <charconv>
#include <cstdio>
#include <optional>

#include "apps/command_line.h"
#include "apps/daemon.h"
#include "apps/service.h"
#include "gprodom/odometry.h"

using namespace gprodom;

namespace {

int priority(const std::string& text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || value < 1 || value > 99) {
    throw UsageError("--realtime: expected a priority from 1 to 99, got " + text);
  }
  return value;
}

}  // namespace

int main(int argc, char** argv) {
  DaemonOptions options;
  bool check_config = false;
  bool print_config = false;
  std::optional<int> realtime;
  const CommandLine command_line(
      "gprodomd",
      "-c CONFIG [--set KEY=VALUE]... [--lcm-url URL] [--realtime PRIORITY] [--check-config] "
      "[--print-config]",
      "Estimates a robot's motion from radar, IMU and wheel messages on LCM, and publishes it.\n"
      "SIGINT and SIGTERM end it; SIGHUP rereads the config.",
      {{"-c, --config", "CONFIG", "YAML file with the keys that differ from the defaults",
        [&](const std::string& path) { options.config_path = path; }},
       {"--set", "KEY=VALUE", "override one key, such as wheel.scale=0.97; may be repeated",
        [&](const std::string& text) { options.overrides.push_back(text); }},
       {"--lcm-url", "URL", std::string("default ") + kDefaultLcmUrl,
        [&](const std::string& url) { options.lcm_url = url; }},
       {"--realtime", "PRIORITY", "SCHED_FIFO at 1 to 99, and locked memory",
        [&](const std::string& text) { realtime = priority(text); }},
       {"--check-config", "", "check CONFIG and end",
        [&](const std::string&) { check_config = true; }},
       {"--print-config", "", "print all keys as they stand (-c is not needed) and end",
        [&](const std::string&) { print_config = true; }}});
  if (command_line.answer(argc, argv)) return 0;

  return command_line.run([&] {
    const auto others = command_line.parse(argc, argv);
    if (!others.empty()) throw UsageError("unexpected argument " + others.front());
    if (print_config) {
      const Config config = options.config_path.empty()
                                ? default_config(options.overrides)
                                : load_config(options.config_path, options.overrides);
      std::fputs(describe_config(config).c_str(), stdout);
      return 0;
    }
    if (options.config_path.empty()) throw UsageError("-c CONFIG is needed");
    if (check_config) {
      const Odometry consistent(load_config(options.config_path, options.overrides));
      std::printf("%s: ok\n", options.config_path.c_str());
      return 0;
    }
    if (realtime) run_in_real_time(*realtime);
    Daemon(options).run();
    return 0;
  });
}
