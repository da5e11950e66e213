#include "apps/replay_report.h"

#include <cstdio>

namespace gprodom {

void ProgressReport::show(double share) {
  const int percent = static_cast<int>(100 * share);
  if (percent == last_percent_) return;
  last_percent_ = percent;
  if (lines_) std::fprintf(stderr, "progress %.2f\n", share);
  if (terminal_) std::fprintf(stderr, "\r%3d %%", percent);
}

void ProgressReport::end() {
  if (lines_) std::fprintf(stderr, "progress 1.00\n");
  if (terminal_ && last_percent_ >= 0) std::fprintf(stderr, "\r     \r");
}

void print_summary(const ReplayStats& stats, const ReplayFiles& files) {
  for (const auto& line : stats.damage) std::fprintf(stderr, "warning: %s\n", line.c_str());
  for (const auto& line : stats.warnings) std::fprintf(stderr, "warning: %s\n", line.c_str());
  std::printf("%s: %.1f s of data in %.1f s, %.0f times real time; %ld poses in %s\n",
              files.input.c_str(), stats.log_seconds, stats.wall_seconds,
              stats.log_seconds / stats.wall_seconds, stats.poses, files.output.c_str());
}

}  // namespace gprodom
