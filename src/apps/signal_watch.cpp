#include "apps/signal_watch.h"

#include <poll.h>
#include <pthread.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string>

namespace gprodom {

namespace {

// Libraries that start threads as they are loaded (OpenBLAS) leave the signals open there: what
// comes to such a thread is passed to the main one, whose number is the process's.
void pass_to_main_thread(int signal) {
  const int error = errno;
  tgkill(getpid(), getpid(), signal);
  errno = error;
}

}  // namespace

SignalWatch::SignalWatch(const std::vector<int>& signals) {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : signals) {
    sigaddset(&set, signal);
    struct sigaction action {};
    action.sa_handler = pass_to_main_thread;
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
  }
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  descriptor_ = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  if (descriptor_ < 0) throw std::runtime_error(std::string("signalfd: ") + std::strerror(errno));
}

SignalWatch::~SignalWatch() { close(descriptor_); }

int SignalWatch::wait() {
  int signal = 0;
  while (signal == 0) signal = read(-1);
  return signal;
}

int SignalWatch::poll() { return read(0); }

int SignalWatch::read(int timeout_ms) {
  pollfd ready{descriptor_, POLLIN, 0};
  if (::poll(&ready, 1, timeout_ms) <= 0) return 0;
  signalfd_siginfo info{};
  return ::read(descriptor_, &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo)
                                                                : 0;
}

}  // namespace gprodom
