// Users' factors that wait for the state interval of their last moment.
#pragma once

#include <string>
#include <vector>

#include "gprodom/types.h"
#include "gprodom/user_factor.h"

namespace gprodom {

class FactorQueue {
 public:
  // Returns why the factor is refused; empty if it is accepted. oldest: begin of the solver's
  // window. latest: the latest moment that is accepted.
  std::string add(UserFactor factor, TimeNs oldest, TimeNs latest);

  // Removes and returns those whose last moment is at most `to`, in the order of add().
  std::vector<UserFactor> take(TimeNs to);

 private:
  std::vector<UserFactor> waiting_;
};

}  // namespace gprodom
