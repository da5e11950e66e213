// Scheduling hints: for threads that must not delay others, and for threads that must not be
// delayed.
#pragma once

namespace gprodom {

// When it wakes up, the calling thread no longer preempts a running one. Otherwise the kernel may
// put a worker on the core of the thread that has just given it a job, and that thread waits for
// the job although its own work is urgent. Real-time threads are not changed.
void stay_in_background();

// Asks for short time slices, since the calling thread works for a fraction of a millisecond at a
// time. An EEVDF scheduler (Linux 6.12 and later) then runs it before a longer slice of another
// thread has ended.
void run_in_short_turns();

}  // namespace gprodom
