// Follows the stretch of travel times between the ground now and the ground of an earlier drive:
// with each place found, a small step of it is tried. docs/revisit.md, "Ground that changed".
#pragma once

#include <functional>
#include <optional>

#include "gpr/revisit/revisit.h"
#include "gpr/revisit/trace_memory.h"

namespace gprodom {

class StretchFollower {
 public:
  // ln of travel times now over then, as believed.
  double stretch() const { return stretch_; }
  void believe(double stretch) { stretch_ = stretch; }

  // Moves it by a step if the query fits better so at the column where it was found. query: its
  // features with a stretch; of as many columns as are compared. Only one side is tried each time,
  // which bounds the cost.
  void follow(const gpr::TraceMemory& memory, double column,
              const std::function<gpr::Columns(double)>& query);

 private:
  std::optional<gpr::PatchMatcher> matcher_;
  double stretch_ = 0.0;
  double step_ = 0.01;  // that is tried next
};

}  // namespace gprodom
