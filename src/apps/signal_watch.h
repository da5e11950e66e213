// Signals as data to be read, in place of handlers.
#pragma once

#include <vector>

namespace gprodom {

// Make it on the main thread, which also is the one to ask it, before any other thread starts:
// threads inherit which signals are blocked.
class SignalWatch {
 public:
  // Throws std::runtime_error.
  explicit SignalWatch(const std::vector<int>& signals);
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  // Waits for one of the signals and returns its number.
  int wait();

  // The same without waiting; 0 where none has come.
  int poll();

 private:
  int read(int timeout_ms);

  int descriptor_;
};

}  // namespace gprodom
