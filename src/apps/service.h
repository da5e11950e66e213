// What a service manager (systemd) is told and asks for. Without one nothing is said.
#pragma once

#include <atomic>
#include <chrono>
#include <string>

namespace gprodom {

class Service {
 public:
  Service();

  void ready();
  void reloading();
  void stopping();
  void status(const std::string& text);  // one line, shown by systemctl status

  // Feeds the watchdog; call it as often as you like. Any thread.
  void alive();

 private:
  using Clock = std::chrono::steady_clock;

  Clock::duration feed_period_;  // zero: there is no watchdog
  std::atomic<Clock::rep> next_feed_{0};
};

// Whether standard error goes to the journal, which takes a line's level from a prefix.
bool stderr_is_journal();

// From here on SCHED_FIFO at `priority` (1 to 99) for all threads and those they start, and
// memory that it has once touched is never paged out. Throws std::runtime_error, with what is
// missing.
void run_in_real_time(int priority);

}  // namespace gprodom
