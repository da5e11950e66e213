// Users' factors that wait for the state interval which their last moment lies in.
#pragma once

#include <string>
#include <vector>

#include "gprodom/types.h"
#include "gprodom/user_factor.h"

namespace gprodom {

class FactorQueue {
 public:
  // Returns why the factor is refused; empty: it waits. oldest: begin of the solver's window.
  // latest: up to where a moment may lie ahead.
  std::string add(UserFactor factor, TimeNs oldest, TimeNs latest);

  // Those whose last moment is `to` or before it, in the order they came.
  std::vector<UserFactor> take(TimeNs to);

 private:
  std::vector<UserFactor> waiting_;
};

}  // namespace gprodom
