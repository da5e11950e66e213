// The estimator on threads of its own: inputs are queued from any thread, estimated on one thread
// and handed out on another, so that neither a slow solver nor a slow network makes a receiver
// wait.
#pragma once

#include <functional>
#include <memory>

#include "gprodom/config.h"
#include "gprodom/export.h"
#include "gprodom/front_end.h"
#include "gprodom/input.h"
#include "gprodom/outputs.h"

namespace gprodom {

class LiveThreads;

struct LiveOptions {
  // Called on the estimator thread, before each input and once a second without any: for a
  // watchdog. Empty: nothing is called.
  std::function<void()> alive;
  // Told in each Status as the value kInstance; 0: none.
  double instance = 0.0;
  // A radar front end of your own (gprodom/front_end.h) in place of gpr.front_end.
  gpr::FrontEndFactory front_end;
};

class GPRODOM_EXPORT Live {
 public:
  // Called on the publish thread, in order.
  using Handler = std::function<void(const Outputs&)>;

  // Starts the threads. Throws ConfigError where settings contradict each other.
  Live(const Config& config, Handler handler, LiveOptions options = {});
  ~Live();  // stop()
  Live(const Live&) = delete;
  Live& operator=(const Live&) = delete;

  // Any thread; never waits. What does not fit is dropped and counted in the status.
  void push(Input input);

  // Any thread: a Status of this instance was heard on our own channel. Another one than ours means
  // that two publish there, which is degraded health for as long as it lasts.
  void heard_status(double instance);

  // Takes no more input, works off and hands out what is inside, and ends the threads.
  void stop();

 private:
  std::unique_ptr<LiveThreads> threads_;
};

}  // namespace gprodom
