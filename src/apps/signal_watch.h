// Reads signals as data instead of handling them asynchronously.
#pragma once

#include <vector>

namespace gprodom {

// Create it on the main thread before any other thread starts, since threads inherit the blocked
// signals. Only the main thread may call it.
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
