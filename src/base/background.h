// Threads that must not hold up others.
#pragma once

namespace gprodom {

// The calling thread, when it wakes up, no longer takes a core from one that runs. Otherwise the
// kernel may put a worker on the core of the thread that just gave it a job, which then waits until
// the job is done, although its own work is urgent. Real-time threads stay as they are.
void stay_in_background();

}  // namespace gprodom
