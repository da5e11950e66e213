// Notifications to a service manager (systemd), and its watchdog. Without one, nothing is sent.
#pragma once

#include <atomic>
#include <chrono>
#include <string>

namespace gprodom {

class Service {
 public:
  Service();

  // A state as sd_notify(3) has it: READY=1, RELOADING=1, STOPPING=1, or STATUS= and one line,
  // which systemctl status shows.
  static void tell(const std::string& state);

  // Feeds the watchdog; call it as often as you like. Any thread.
  void alive();

 private:
  using Clock = std::chrono::steady_clock;

  Clock::duration feed_period_;  // zero: there is no watchdog
  std::atomic<Clock::rep> next_feed_{0};
};

// Whether standard error goes to the journal, which takes a line's level from a prefix.
bool stderr_is_journal();

// Switches all threads, and those they will start, to SCHED_FIFO at `priority` (1 to 99), and locks
// the process's memory. Throws std::runtime_error that says what is missing.
void run_in_real_time(int priority);

}  // namespace gprodom
