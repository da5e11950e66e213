// The estimator on threads of its own: inputs are queued from any thread, estimated on one thread
// and handed out on another, so that neither a slow solver nor a slow network makes a receiver
// wait.
//
//   push() → inputs_ → estimator thread → results_ → publish thread → Handler
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "gprodom/input.h"
#include "live/latency_watch.h"
#include "live/message_queue.h"
#include "live/runner.h"

namespace gprodom {

class Live {
 public:
  // Called on the publish thread, in order.
  using Handler = std::function<void(const Results&)>;
  // Called on the estimator thread, before each input and once a second without any.
  using Alive = std::function<void()>;

  // Starts the threads. instance: told in each Status; 0: none. Throws ConfigError where settings
  // contradict each other.
  Live(
      const Config& config, Handler handler, Alive alive = [] {}, double instance = 0.0);
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
  void estimate();
  template <class Work>
  void guarded(Work work);
  void report_losses();
  void tell_of_silence();
  void add_silence(Status& status) const;
  void hand_out(Results results);
  void add_figures(Status& status);
  void tell_of_another(Results& results);
  void publish();

  using Clock = std::chrono::steady_clock;

  // Used by the estimator thread only.
  Runner runner_;
  Clock::time_point last_input_;
  TimeNs last_time_ = 0;  // newest data time estimated
  Alive alive_;
  const double instance_;
  const std::string status_channel_;
  bool another_told_ = false;

  std::atomic<Clock::rep> another_heard_{0};  // when; 0: never; any thread
  const TimeNs imu_offset_;                   // of data time from the stamps of IMU messages
  LatencyWatch imu_latency_;                  // guards itself
  Handler handler_;                           // used by the publish thread only
  MessageQueue<Input> inputs_;                // guards itself
  MessageQueue<Results> results_;             // guards itself
  // Last, so that everything above is there when they start.
  std::thread estimator_;
  std::thread publisher_;
};

}  // namespace gprodom
