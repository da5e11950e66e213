#include "live/live.h"

#include <pthread.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "base/background.h"

namespace gprodom {
namespace {

// Half a minute of IMU, wheel and radar: a solver that is further behind is better told so.
constexpr std::size_t kInputCapacity = 10000;
constexpr std::size_t kResultCapacity = 10000;
constexpr std::chrono::milliseconds kIdle(1000);
constexpr std::chrono::seconds kOther(3);    // for which another's Status, one a second, counts
constexpr std::chrono::seconds kSilence(2);  // without any input before the status tells of it

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

}  // namespace

Live::Live(const Config& config, Handler handler, Alive alive, double instance)
    : runner_(config, Execution::kThreaded),
      last_input_(Clock::now()),
      alive_(std::move(alive)),
      instance_(instance),
      status_channel_(config.channels.status),
      imu_offset_(from_seconds(config.imu.time_offset)),
      handler_(std::move(handler)),
      inputs_(kInputCapacity),
      results_(kResultCapacity),
      estimator_([this] { estimate(); }),
      publisher_([this] { publish(); }) {}

Live::~Live() { stop(); }

void Live::push(Input input) {
  if (const auto* imu = std::get_if<ImuSample>(&input))
    imu_latency_.arrived(imu->time + imu_offset_);
  inputs_.push(std::move(input));
}

void Live::heard_status(double instance) {
  if (instance != instance_) another_heard_ = Clock::now().time_since_epoch().count();
}

void Live::stop() {
  inputs_.close();
  if (estimator_.joinable()) estimator_.join();
  results_.close();
  if (publisher_.joinable()) publisher_.join();
}

void Live::estimate() {
  run_in_short_turns();
  pthread_setname_np(pthread_self(), "estimator");  // for top -H and the like
  while (!inputs_.finished()) {
    const auto batch = inputs_.pop_all(kIdle);
    alive_();
    for (const auto& input : batch) {
      last_input_ = Clock::now();
      alive_();
      guarded([&] { return runner_.feed(input); });
      runner_.start_jobs();  // a solve is not as urgent as the pose
    }
    if (batch.empty()) {
      guarded([&] { return runner_.step(); });
      tell_of_silence();
    }
    report_losses();
  }
  guarded([&] { return runner_.finish(); });
}

// A fault of our own must not take the robot's daemon down.
template <class Work>
void Live::guarded(Work work) {
  try {
    hand_out(work());
  } catch (const std::exception& error) {
    runner_.forget();
    Results results;
    results.outputs.warnings.push_back(std::string("internal error: ") + error.what() +
                                       "; the estimator starts afresh");
    hand_out(std::move(results));
  }
}

void Live::report_losses() {
  for (auto lost = inputs_.take_dropped(); lost > 0; --lost) {
    runner_.reject("input queue", "message dropped: the estimator is slower than its input");
  }
  for (auto lost = results_.take_dropped(); lost > 0; --lost) {
    runner_.reject("output queue", "result dropped: publishing is slower than the estimator");
  }
}

// The estimator knows data time alone, so a robot whose sensors have all stopped would just fall
// silent. Stamped with the newest data time there is.
void Live::tell_of_silence() {
  if (Clock::now() - last_input_ < kSilence) return;
  Results results;
  results.outputs.status.emplace_back().time = last_time_;
  hand_out(std::move(results));
}

// Into whatever Status there is, also the last one of a daemon that is stopped amid the silence.
void Live::add_silence(Status& status) const {
  const auto silence = Clock::now() - last_input_;
  if (silence < kSilence) return;
  const auto whole_s = std::chrono::duration_cast<std::chrono::seconds>(silence).count();
  status.health = HealthLevel::kFailed;
  status.reasons.push_back("no input for " + std::to_string(whole_s) +
                           " s; are the sensor drivers running, on this LCM URL?");
}

void Live::hand_out(Results results) {
  if (results.empty()) return;
  for (Status& status : results.outputs.status) {
    add_silence(status);
    add_figures(status);
  }
  tell_of_another(results);
  if (!results.outputs.odometry.empty()) last_time_ = results.outputs.odometry.back().time;
  if (!results.outputs.status.empty()) last_time_ = results.outputs.status.back().time;
  results_.push(std::move(results));
}

// Each estimator publishes a Status a second, and a reader cannot tell whose poses he gets.
void Live::tell_of_another(Results& results) {
  if (results.outputs.status.empty()) return;
  const Clock::rep heard = another_heard_;
  const bool lasts = heard > 0 && Clock::now() - Clock::time_point(Clock::duration(heard)) < kOther;
  const std::string topic = status_channel_ + ": ";
  const std::string reason = "another estimator publishes on our channels";
  if (lasts != another_told_)
    results.outputs.warnings.push_back(topic + (lasts ? "" : "over: ") + reason);
  another_told_ = lasts;
  if (!lasts) return;
  for (Status& status : results.outputs.status) {
    status.health = std::max(status.health, HealthLevel::kDegraded);
    status.reasons.push_back(topic + reason);
  }
}

// What the wall clock says, and whose it is.
void Live::add_figures(Status& status) {
  const Timing timing = runner_.timing();
  add("solver", timing.solver, status);
  add("radar", timing.radar, status);
  add("latency.imu", imu_latency_.latencies(), status);
  add("latency.radar", timing.radar.ready, status);
  add("queue.input.longest", static_cast<double>(inputs_.take_longest()), status);
  add("queue.output.longest", static_cast<double>(results_.take_longest()), status);
  if (instance_ > 0) add(kInstance, instance_, status);
}

void Live::publish() {
  run_in_short_turns();
  pthread_setname_np(pthread_self(), "publisher");
  while (!results_.finished()) {
    for (const auto& results : results_.pop_all(kIdle)) {
      handler_(results);
      for (const auto& estimate : results.outputs.odometry) imu_latency_.published(estimate.time);
    }
  }
}

}  // namespace gprodom
