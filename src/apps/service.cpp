#include "apps/service.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace gprodom {

Service::Service() : feed_period_(Clock::duration::zero()) {
  std::uint64_t timeout_us = 0;
  if (sd_watchdog_enabled(0, &timeout_us) > 0) {
    feed_period_ = std::chrono::microseconds(timeout_us / 4);
  }
}

void Service::tell(const std::string& state) { sd_notify(0, state.c_str()); }

void Service::alive() {
  if (feed_period_ == Clock::duration::zero()) return;
  const Clock::rep now = Clock::now().time_since_epoch().count();
  if (now < next_feed_.load(std::memory_order_relaxed)) return;
  next_feed_.store(now + feed_period_.count(), std::memory_order_relaxed);
  tell("WATCHDOG=1");
}

bool stderr_is_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");  // "device:inode" of the journal's end
  struct stat file {};
  if (!stream || fstat(STDERR_FILENO, &file) != 0) return false;
  return stream == std::to_string(file.st_dev) + ":" + std::to_string(file.st_ino);
}

void run_in_real_time(int priority) {
  auto refused = [](const std::string& what) {
    return std::runtime_error("--realtime: " + what + ": " + std::strerror(errno));
  };
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    throw refused("memory cannot be locked (it takes CAP_IPC_LOCK, or the limit MEMLOCK)");
  }
  sched_param parameters{};
  parameters.sched_priority = priority;
  // Some libraries, such as OpenBLAS, start threads as they are loaded.
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (sched_setscheduler(std::stoi(task.path().filename()), SCHED_FIFO, &parameters) != 0) {
      throw refused("no real-time priority (it takes CAP_SYS_NICE, or the limit RTPRIO)");
    }
  }
}

}  // namespace gprodom
