// push() → inputs_ → estimator thread → results_ → publish thread → Handler
#include "gprodom/live.h"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include "base/background.h"
#include "live/latency_watch.h"
#include "live/message_queue.h"
#include "live/runner.h"

namespace gprodom {
namespace {

// Half a minute of IMU, wheel and radar. An estimator that is further behind drops messages.
constexpr std::size_t kInputCapacity = 10000;
constexpr std::size_t kResultCapacity = 10000;
constexpr std::chrono::milliseconds kIdle(1000);
constexpr std::chrono::seconds kOther(3);    // how long a Status of another estimator counts
constexpr std::chrono::seconds kSilence(2);  // time without input until the status reports it

// A live estimator runs on its robot, whose name goes into the maps that it makes.
Config of_this_host(Config config) {
  std::array<char, 100> name{};
  if (config.state.robot.empty() && gethostname(name.data(), name.size() - 1) == 0)
    config.state.robot = name.data();
  return config;
}

void add(const std::string& name, double value, Status& status) {
  status.names.push_back(name);
  status.values.push_back(value);
}

void add(const std::string& name, const WorkTime& time, Status& status) {
  const double jobs = static_cast<double>(std::max<std::int64_t>(time.jobs, 1));
  add(name + ".mean_ms", 1e3 * time.total_s / jobs, status);
  add(name + ".longest_ms", 1e3 * time.longest_s, status);
}

void add(const std::string& name, const DurationHistogram& durations, Status& status) {
  add(name + ".p50_ms", 1e3 * durations.quantile(0.5), status);
  add(name + ".p99_ms", 1e3 * durations.quantile(0.99), status);
  add(name + ".p999_ms", 1e3 * durations.quantile(0.999), status);
  add(name + ".longest_ms", 1e3 * durations.longest(), status);
}

std::string text_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "not a std::exception";
  }
}

}  // namespace

class LiveThreads {
 public:
  LiveThreads(const Config& config, Live::Handler handler, LiveOptions options);
  ~LiveThreads() { stop(); }
  LiveThreads(const LiveThreads&) = delete;
  LiveThreads& operator=(const LiveThreads&) = delete;

  void push(Input input);
  void heard_status(double instance);
  void stop();

 private:
  void estimate();
  void tell_alive() const;
  template <class Work>
  bool guarded(Work work);
  void recover(const std::exception_ptr& failure);
  void report_losses();
  void report_silence();
  void add_silence(Status& status) const;
  void hand_out(Outputs outputs);
  void add_figures(Status& status);
  void report_other_estimator(Outputs& outputs);
  void publish();

  using Clock = std::chrono::steady_clock;

  // Used by the estimator thread only.
  Runner runner_;
  Clock::time_point last_input_;
  TimeNs last_time_ = 0;  // newest data time estimated
  const std::function<void()> alive_;
  const double instance_;
  const std::string status_channel_;
  bool another_reported_ = false;
  std::exception_ptr to_recover_;  // the estimator has failed with it, and not restarted yet
  Clock::time_point recover_again_;

  std::atomic<Clock::rep> another_heard_{0};  // when; 0: never; any thread
  const TimeNs imu_offset_;                   // of data time from the stamps of IMU messages
  LatencyWatch imu_latency_;                  // guards itself
  const Live::Handler handler_;               // used by the publish thread only
  MessageQueue<Input> inputs_;                // guards itself
  MessageQueue<Outputs> results_;             // guards itself
  // Last members, since they use all of the above as soon as they start.
  std::thread estimator_;
  std::thread publisher_;
};

Live::Live(const Config& config, Handler handler, LiveOptions options)
    : threads_(std::make_unique<LiveThreads>(config, std::move(handler), std::move(options))) {}
Live::~Live() = default;
void Live::push(Input input) { threads_->push(std::move(input)); }
void Live::heard_status(double instance) { threads_->heard_status(instance); }
void Live::stop() { threads_->stop(); }

LiveThreads::LiveThreads(const Config& config, Live::Handler handler, LiveOptions options)
    : runner_(of_this_host(config), Execution::kThreaded, std::move(options.front_end)),
      last_input_(Clock::now()),
      alive_(std::move(options.alive)),
      instance_(options.instance),
      status_channel_(config.channels.status),
      imu_offset_(from_seconds(config.imu.time_offset)),
      handler_(std::move(handler)),
      inputs_(kInputCapacity),
      results_(kResultCapacity),
      estimator_([this] { estimate(); }),
      publisher_([this] { publish(); }) {}

void LiveThreads::push(Input input) {
  if (const auto* imu = std::get_if<ImuSample>(&input))
    imu_latency_.arrived(imu->time + imu_offset_);
  inputs_.push(std::move(input));
}

void LiveThreads::heard_status(double instance) {
  if (instance != instance_) another_heard_ = Clock::now().time_since_epoch().count();
}

void LiveThreads::stop() {
  inputs_.close();
  if (estimator_.joinable()) estimator_.join();
  results_.close();
  if (publisher_.joinable()) publisher_.join();
}

void LiveThreads::estimate() {
  run_in_short_turns();
  pthread_setname_np(pthread_self(), "estimator");  // for top -H and the like
  while (!inputs_.finished()) {
    const auto batch = inputs_.pop_all(kIdle);
    tell_alive();
    for (const auto& input : batch) {
      last_input_ = Clock::now();
      tell_alive();
      guarded([&] { return runner_.feed(input); });
      runner_.start_jobs();  // after the pose, which is more urgent than a solve
    }
    if (batch.empty()) {
      guarded([&] { return runner_.step(); });
      report_silence();
    }
    report_losses();
  }
  const auto finish = [&] { return runner_.finish(); };
  if (!guarded(finish)) guarded(finish);  // the ground is saved here
}

void LiveThreads::tell_alive() const {
  if (alive_) alive_();
}

// A defect of the estimator, or of what a user has plugged into it, must not end the robot's
// daemon. False where the work has failed.
template <class Work>
bool LiveThreads::guarded(Work work) {
  std::exception_ptr failure = to_recover_;
  if (failure && Clock::now() < recover_again_) return false;
  try {
    if (!failure) {
      hand_out(work());
      return true;
    }
  } catch (...) {
    failure = std::current_exception();
  }
  recover(failure);
  return false;
}

// Restarts the estimator. What fails at that, such as the constructor of a front end, is tried
// again.
void LiveThreads::recover(const std::exception_ptr& failure) {
  Outputs outputs;
  const std::string said = "internal error: " + text_of(failure);
  try {
    runner_.recover(failure);
    outputs.warnings.push_back(said + "; the estimator restarts");
    to_recover_ = nullptr;
  } catch (...) {
    if (!to_recover_)
      outputs.warnings.push_back(
          said + "; the estimator cannot restart: " + text_of(std::current_exception()));
    to_recover_ = failure;
    recover_again_ = Clock::now() + kIdle;
  }
  hand_out(std::move(outputs));
}

void LiveThreads::report_losses() {
  for (auto lost = inputs_.take_dropped(); lost > 0; --lost) {
    runner_.reject("input queue", "message dropped: the estimator is slower than its input");
  }
  for (auto lost = results_.take_dropped(); lost > 0; --lost) {
    runner_.reject("output queue", "result dropped: publishing is slower than the estimator");
  }
}

// The estimator knows data time only, so it says nothing when all sensors have stopped. This gives
// a Status then, stamped with the newest data time.
void LiveThreads::report_silence() {
  if (Clock::now() - last_input_ < kSilence) return;
  Outputs outputs;
  outputs.status.emplace_back().time = last_time_;
  hand_out(std::move(outputs));
}

// Added to every Status, also to the last one of a daemon that is stopped during the silence.
void LiveThreads::add_silence(Status& status) const {
  const auto silence = Clock::now() - last_input_;
  if (silence < kSilence) return;
  const auto whole_s = std::chrono::duration_cast<std::chrono::seconds>(silence).count();
  status.health = HealthLevel::kFailed;
  status.reasons.push_back("no input for " + std::to_string(whole_s) +
                           " s; are the sensor drivers running, on this network?");
}

void LiveThreads::hand_out(Outputs outputs) {
  if (is_empty(outputs)) return;
  for (Status& status : outputs.status) {
    add_silence(status);
    add_figures(status);
  }
  report_other_estimator(outputs);
  if (!outputs.odometry.empty()) last_time_ = outputs.odometry.back().time;
  if (!outputs.status.empty()) last_time_ = outputs.status.back().time;
  results_.push(std::move(outputs));
}

// Reports another estimator on our channels: a reader cannot distinguish the poses of the two.
void LiveThreads::report_other_estimator(Outputs& outputs) {
  if (outputs.status.empty()) return;
  const Clock::rep heard = another_heard_;
  const bool lasts = heard > 0 && Clock::now() - Clock::time_point(Clock::duration(heard)) < kOther;
  const std::string topic = status_channel_ + ": ";
  const std::string reason = "another estimator publishes on our channels";
  if (lasts != another_reported_)
    outputs.warnings.push_back(topic + (lasts ? "" : "over: ") + reason);
  another_reported_ = lasts;
  if (!lasts) return;
  for (Status& status : outputs.status) {
    status.health = std::max(status.health, HealthLevel::kDegraded);
    status.reasons.push_back(topic + reason);
  }
}

// Adds the figures of the wall clock, and the instance of this estimator.
void LiveThreads::add_figures(Status& status) {
  const Timing timing = runner_.timing();
  add("solver", timing.solver, status);
  add("radar", timing.radar, status);
  add("latency.imu", imu_latency_.latencies(), status);
  add("latency.radar", timing.radar.ready, status);
  add("queue.input.longest", static_cast<double>(inputs_.take_longest()), status);
  add("queue.output.longest", static_cast<double>(results_.take_longest()), status);
  if (instance_ > 0) add(kInstance, instance_, status);
}

void LiveThreads::publish() {
  run_in_short_turns();
  pthread_setname_np(pthread_self(), "publisher");
  while (!results_.finished()) {
    for (const Outputs& outputs : results_.pop_all(kIdle)) {
      handler_(outputs);
      for (const auto& estimate : outputs.odometry) imu_latency_.published(estimate.time);
    }
  }
}

}  // namespace gprodom
