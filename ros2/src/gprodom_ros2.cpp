// gprodom_ros2: the estimator as a ROS 2 node.
#include <systemd/sd-daemon.h>

#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "apps/command_line.h"
#include "apps/service.h"
#include "apps/signal_watch.h"
#include "base/text.h"
#include "gprodom/version.h"
#include "ros2_node.h"

using namespace gprodom;

namespace {

struct Options {
  std::vector<std::string> configs, overrides, settings, values;
  bool check = false, print = false;
};

void say(const char* level, const std::string& text) {
  std::fprintf(stderr, "%s%s\n", stderr_is_journal() ? level : "", text.c_str());
}

void run(const Options& options) {
  SignalWatch signals({SIGINT, SIGTERM});  // before any thread
  const auto settings = ros2::load_settings(options.settings, options.values);
  if (options.print) {
    std::fputs(ros2::describe(settings).c_str(), stdout);
    return;
  }
  std::vector<std::string> notices;
  const Config config = load_config(options.configs, options.overrides, &notices);
  for (const auto& notice : notices) say(SD_INFO, notice);
  if (options.check) return;

  Service service;
  std::string health;  // last said
  ros2::NodeHooks hooks;
  hooks.alive = [&] { service.alive(); };
  hooks.warning = [](const std::string& text) { say(SD_WARNING, text); };
  hooks.status = [&](const Status& status) {
    const std::string reasons = joined(status.reasons, "; ");
    const std::string text =
        "health: " + name_of(status.health) + (reasons.empty() ? "" : ": " + reasons);
    if (text == health) return;
    say(status.health == HealthLevel::kOk ? SD_INFO : SD_WARNING, text);
    Service::tell("STATUS=" + text);
    health = text;
  };
  ros2::Ros2Node node(config, settings, hooks);
  say(SD_INFO, std::string("gprodom_ros2 ") + kVersion + " runs: domain " +
                   std::to_string(settings.domain) + ", interface '" + settings.interface + "'");
  Service::tell("READY=1");
  while (signals.poll() == 0) node.receive();
  Service::tell("STOPPING=1");
  say(SD_INFO, "stopping");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const CommandLine command_line(
      "gprodom_ros2",
      "[-c CONFIG]... [--set KEY=VALUE]... [--settings FILE]... [-p NAME:=VALUE]... "
      "[--check-config] [--print-settings]",
      "Estimates a robot's motion from radar, IMU and wheel messages of ROS 2, and publishes it.\n"
      "It needs no ROS 2: it speaks DDS as ROS 2 does. SIGINT and SIGTERM end it.",
      {config_option(options.configs),
       set_option(options.overrides),
       {"--settings", "FILE", "settings of topics, frames and network; may be repeated",
        [&](const std::string& path) { options.settings.push_back(path); }},
       {"-p, --param", "NAME:=VALUE", "one of these settings; may be repeated",
        [&](const std::string& value) { options.values.push_back(value); }},
       {"--check-config", "", "check configuration and settings, and end",
        [&](const std::string&) { options.check = true; }},
       {"--print-settings", "", "print all settings with their values, and end",
        [&](const std::string&) { options.print = true; }}});
  return command_line.run([&] {
    if (command_line.answer(argc, argv)) return 0;
    const auto others = command_line.parse(argc, argv);
    if (!others.empty()) throw UsageError("unexpected argument " + others.front());
    run(options);
    return 0;
  });
}
