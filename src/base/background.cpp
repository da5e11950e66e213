#include "base/background.h"

#include <sched.h>

namespace gprodom {

void stay_in_background() {
  const sched_param parameters{};
  // Where it is refused, the thread is as any other, which costs latency and no result.
  if (sched_getscheduler(0) == SCHED_OTHER) sched_setscheduler(0, SCHED_BATCH, &parameters);
}

}  // namespace gprodom
