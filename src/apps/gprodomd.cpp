// gprodomd: the odometry daemon.
#include <charconv>
#include <cstdio>
#include <optional>

#include "apps/command_line.h"
#include "apps/daemon.h"
#include "apps/service.h"

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
      "-c CONFIG [-c CONFIG]... [--set KEY=VALUE]... [--lcm-url URL] [--realtime PRIORITY] "
      "[--check-config] [--print-config]",
      "Estimates a robot's motion from radar, IMU and wheel messages on LCM, and publishes it.\n"
      "SIGINT and SIGTERM end it; SIGHUP rereads the config.",
      {config_option(options.config_paths),
       set_option(options.overrides),
       {"--lcm-url", "URL", std::string("default ") + kDefaultLcmUrl,
        [&](const std::string& url) { options.lcm_url = url; }},
       {"--realtime", "PRIORITY", "SCHED_FIFO at 1 to 99, and locked memory",
        [&](const std::string& text) { realtime = priority(text); }},
       {"--check-config", "", "check the config and end",
        [&](const std::string&) { check_config = true; }},
       {"--print-config", "", "print all keys with their values (-c is not needed) and end",
        [&](const std::string&) { print_config = true; }}});
  return command_line.run([&] {
    if (command_line.answer(argc, argv)) return 0;
    const auto others = command_line.parse(argc, argv);
    if (!others.empty()) throw UsageError("unexpected argument " + others.front());
    if (print_config) {
      const Config config = load_config(options.config_paths, options.overrides);
      std::fputs(describe_config(config).c_str(), stdout);
      return 0;
    }
    if (options.config_paths.empty()) throw UsageError("-c CONFIG is needed");
    if (check_config) {
      std::vector<std::string> notices;
      check_consistency(load_config(options.config_paths, options.overrides, &notices));
      for (const auto& notice : notices) std::printf("%s\n", notice.c_str());
      for (const auto& path : options.config_paths) std::printf("%s: ok\n", path.c_str());
      return 0;
    }
    if (realtime) run_in_real_time(*realtime);
    Daemon(options).run();
    return 0;
  });
}
