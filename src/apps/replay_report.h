// What gprodom-replay prints: progress, warnings, figures.
#pragma once

#include <string>

#include "apps/replay.h"

namespace gprodom {

// Prints the progress of the replay on stderr: lines `progress 0.42` for programs, or one changing
// line on a terminal; otherwise nothing.
class ProgressReport {
 public:
  ProgressReport(bool lines, bool terminal) : lines_(lines), terminal_(terminal && !lines) {}

  void show(double share);
  void end();

 private:
  bool lines_, terminal_;
  int last_percent_ = -1;
};

// Warnings on stderr, one line of figures on stdout.
void print_summary(const ReplayStats& stats, const ReplayFiles& files);

}  // namespace gprodom
