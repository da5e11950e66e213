// What gprodom-replay shows of its work.
#pragma once

#include <string>

#include "apps/replay.h"

namespace gprodom {

// How far the replay is, on stderr: `progress 0.42` lines for programs, or one line that changes
// for people at a terminal; else nothing.
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
