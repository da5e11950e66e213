// gprodom-replay: a log through the estimator into another log.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "apps/command_line.h"
#include "apps/replay.h"
#include "apps/signal_watch.h"
#include "base/atomic_file.h"

using namespace gprodom;

namespace {

// `paths` if there are any. Otherwise what `gprodom run` takes, too: the robot's own file where the
// program is installed and there is one, else none, which stands for the defaults.
std::vector<std::string> or_default(std::vector<std::string> paths) {
  namespace fs = std::filesystem;
  if (!paths.empty()) return paths;
  // GPRODOM_BINDIR and GPRODOM_CONFIG: where CMake installs programs and the robot's file.
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  const bool installed = fs::equivalent(program.parent_path(), GPRODOM_BINDIR, unknown);
  if (installed && fs::is_regular_file(GPRODOM_CONFIG, unknown)) paths.emplace_back(GPRODOM_CONFIG);
  return paths;
}

// Prints the progress of the replay on stderr: lines `progress 0.42` for programs, or one changing
// line on a terminal; otherwise nothing.
class ProgressReport {
 public:
  ProgressReport(bool lines, bool terminal) : lines_(lines), terminal_(terminal && !lines) {}

  void show(double share) {
    const int percent = static_cast<int>(100 * share);
    if (percent == last_percent_) return;
    last_percent_ = percent;
    if (lines_) std::fprintf(stderr, "progress %.2f\n", share);
    if (terminal_) std::fprintf(stderr, "\r%3d %%", percent);
  }
  void end() {
    if (lines_) std::fprintf(stderr, "progress 1.00\n");
    if (terminal_ && last_percent_ >= 0) std::fprintf(stderr, "\r     \r");
  }

 private:
  bool lines_, terminal_;
  int last_percent_ = -1;
};

// Warnings on stderr, one line of figures on stdout.
void print_summary(const ReplayStats& stats, const ReplayFiles& files) {
  for (const auto* lines : {&stats.damage, &stats.warnings})
    for (const auto& line : *lines) std::fprintf(stderr, "warning: %s\n", line.c_str());
  std::printf("%s: %.1f s of data in %.1f s, %.0f times real time; %ld poses in %s\n",
              files.input.c_str(), stats.log_seconds, stats.wall_seconds,
              stats.log_seconds / stats.wall_seconds, stats.poses, files.output.c_str());
}

}  // namespace

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
