// Follows how traces of the ground differ now from those of an earlier drive: with each place
// found, a small step of it is tried. docs/revisit.md, "Another day".
#pragma once

#include <functional>
#include <optional>

#include "gpr/revisit/revisit.h"
#include "gpr/revisit/trace_memory.h"

namespace gprodom {

class ChangeFollower {
 public:
  // As believed.
  const gpr::TraceChange& change() const { return change_; }
  void believe(const gpr::TraceChange& change) { change_ = change; }

  // Moves it by a step if the query fits better so at the column where it was found. query: its
  // features with a change undone; of as many columns as are compared. Only one side of one figure
  // is tried each time, which bounds the cost.
  void follow(const gpr::TraceMemory& memory, double column,
              const std::function<gpr::Columns(const gpr::TraceChange&)>& query);

 private:
  std::optional<gpr::PatchMatcher> matcher_;
  gpr::TraceChange change_;
  double stretch_step_ = 0.01, turn_step_ = 0.1;  // that are tried next
  bool turns_ = false;                            // the turn is tried next
};

}  // namespace gprodom
