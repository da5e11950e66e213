// gprodom-replay: a log through the estimator into another log.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <stdexcept>

#include "apps/command_line.h"
#include "apps/default_config.h"
#include "apps/replay.h"
#include "apps/replay_report.h"
#include "apps/signal_watch.h"
#include "base/atomic_file.h"

using namespace gprodom;

int main(int argc, char** argv) {
  ReplayFiles files;
  std::vector<std::string> config_paths;
  std::vector<std::string> overrides;
  bool progress_lines = false;
  const CommandLine command_line(
      "gprodom-replay",
      "[-c CONFIG]... [--set KEY=VALUE]... IN.lcmlog -o OUT.lcmlog [--tum TRAJ] "
      "[--smoothed TRAJ] [--stats FILE.json] [--progress]",
      "Runs the estimator over a log and writes what the daemon would have published, stamped "
      "with\n"
      "data time. The same input gives byte-identical output. Without -c it takes the installed\n"
      "gprodom.yaml, in a checkout the defaults.",
      {config_option(config_paths),
       set_option(overrides),
       {"-o, --output", "OUT.lcmlog", "log to write",
        [&](const std::string& path) { files.output = path; }},
       {"--tum", "TRAJ", "also write the trajectory in map, as a TUM file",
        [&](const std::string& path) { files.trajectory = path; }},
       {"--smoothed", "TRAJ", "also write all states of one solution over all data, as a TUM file",
        [&](const std::string& path) { files.smoothed = path; }},
       {"--stats", "FILE.json", "write counts and times as JSON",
        [&](const std::string& path) { files.stats = path; }},
       {"--progress", "", "print `progress 0.42` lines on stderr",
        [&](const std::string&) { progress_lines = true; }}});
  return command_line.run([&] {
    if (command_line.answer(argc, argv)) return 0;
    const auto others = command_line.parse(argc, argv);
    if (files.output.empty()) throw UsageError("-o OUT.lcmlog is needed");
    if (others.size() != 1) throw UsageError("expected one IN.lcmlog");
    files.input = others.front();
    files.configs = config_paths;

    std::vector<std::string> notices;
    const Config config = load_config(or_default(config_paths), overrides, &notices);
    for (const auto& notice : notices) std::fprintf(stderr, "%s\n", notice.c_str());
    SignalWatch signals({SIGINT, SIGTERM});
    ProgressReport progress(progress_lines, isatty(STDERR_FILENO) != 0);
    const ReplayStats stats =
        replay(config, files,
               {[&](double share) { progress.show(share); }, [&] { return signals.poll() != 0; }});
    progress.end();
    print_summary(stats, files);
    if (!files.stats.empty()) write_whole(files.stats, to_json(stats));
    if (stats.poses == 0) throw std::runtime_error("no pose was estimated: " + stats.why_no_pose);
    return 0;
  });
}
