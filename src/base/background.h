// Threads that must not hold up others, and those that must not be held up.
#pragma once

namespace gprodom {

// The calling thread, when it wakes up, no longer takes a core from one that runs. Otherwise the
// kernel may put a worker on the core of the thread that just gave it a job, which then waits until
// the job is done, although its own work is urgent. Real-time threads stay as they are.
void stay_in_background();

// The calling thread works for a fraction of a millisecond at once: a kernel that shares the
// processor out in turns (EEVDF; so from Linux 6.12 on) lets it in before a longer turn of another
// thread is over.
void run_in_short_turns();

}  // namespace gprodom
