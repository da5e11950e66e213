// The estimator with its own threads. Inputs can be queued from any thread. One thread estimates,
// and another one publishes, so that a receiver never waits for a slow solver or a slow network.
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
  // For a watchdog: called on the estimator thread before each input, and once a second without
  // input. May be empty.
  std::function<void()> alive;
  // Published in each Status as the value kInstance; 0: not published.
  double instance = 0.0;
  // A radar front end of your own (gprodom/front_end.h) instead of gpr.front_end.
  gpr::FrontEndFactory front_end;
};

class GPRODOM_EXPORT Live {
 public:
  // Called on the publish thread, in order.
  using Handler = std::function<void(const Outputs&)>;

  // Starts the threads. Throws ConfigError if settings contradict each other.
  Live(const Config& config, Handler handler, LiveOptions options = {});
  ~Live();  // stop()
  Live(const Live&) = delete;
  Live& operator=(const Live&) = delete;

  // Any thread; never waits. If the queue is full, the input is dropped and the status counts it.
  void push(Input input);

  // Any thread. A Status with this instance was received on our own channel. If the instance is not
  // ours, two estimators publish there, and health is degraded while that lasts.
  void heard_status(double instance);

  // Takes no more input, processes and publishes what is queued, and ends the threads.
  void stop();

 private:
  std::unique_ptr<LiveThreads> threads_;
};

}  // namespace gprodom
