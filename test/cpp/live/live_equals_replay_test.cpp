// One drive through the threaded estimator and through a replay.
#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "gprodom/live.h"
#include "live/runner.h"
#include "pipeline/test_drive.h"
#include "support/told.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(__clang__)
constexpr double kPace = 2.0;  // s of data in a second
#else
constexpr double kPace = 10.0;
#endif

namespace gprodom {
namespace {

// All outputs, one line each, with numbers to the last bit.
class Lines {
 public:
  void add(const Outputs& outputs) {
    for (const auto& estimate : outputs.odometry) add("odom", estimate);
    for (const auto& estimate : outputs.odometry_in_map) add("map", estimate);
    for (const Displacement& d : outputs.displacements) {
      line("displacement", d.time) << d.source << ' ' << d.from << ' ' << d.to << ' ' << d.valid;
      text_ << ' ' << d.distance_m << ' ' << d.sigma_m << ' ' << d.lateral_m << ' ' << d.score;
    }
    for (const Correction& c : outputs.corrections) {
      line("correction", c.time) << c.revisits;
      put(c.p_map_odom), put(c.q_map_odom.coeffs()), put(c.covariance);
      ++corrections_;
    }
    for (const Status& status : outputs.status) add(status);
    for (const std::string& warning : outputs.warnings) line("warning", 0) << warning;
  }
  int corrections() const { return corrections_; }
  std::vector<std::string> take() const {
    std::vector<std::string> lines;
    std::istringstream stream(text_.str());
    for (std::string one; std::getline(stream, one);) lines.push_back(one);
    return lines;
  }

 private:
  std::ostream& line(const char* kind, TimeNs time) {
    return text_ << '\n' << std::hexfloat << kind << ' ' << time << ' ';
  }
  template <class Matrix>
  void put(const Matrix& matrix) {
    for (const double x : matrix.reshaped()) text_ << ' ' << x;
  }
  void add(const char* kind, const OdometryEstimate& x) {
    line(kind, x.time) << x.flags << ' ' << x.distance_m << ' ' << x.wheel_scale;
    put(x.p_odom_body), put(x.q_odom_body.coeffs()), put(x.v_body), put(x.omega_body);
    put(x.pose_covariance), put(x.velocity_covariance), put(x.gyro_bias), put(x.accel_bias);
  }
  // What the wall clock says is added by Live alone.
  void add(const Status& status) {
    line("status", status.time) << static_cast<int>(status.health);
    for (const std::string& reason : status.reasons) text_ << ' ' << reason;
    for (std::size_t i = 0; i < status.names.size() && status.names[i] != "solver.mean_ms"; ++i)
      text_ << ' ' << status.names[i] << ' ' << status.values[i];
  }

  std::ostringstream text_;
  int corrections_ = 0;
};

Lines replayed(const Config& config, const std::vector<Input>& inputs) {
  Lines lines;
  Runner runner(config, Execution::kInline);
  for (const Input& input : inputs) lines.add(runner.feed(input));
  lines.add(runner.finish());
  return lines;
}

Lines lived(const Config& config, const std::vector<Input>& inputs, double pace) {
  Lines lines;
  Live live(config, [&lines](const Outputs& outputs) { lines.add(outputs); });
  const auto start = std::chrono::steady_clock::now();
  for (const Input& input : inputs) {
    if (const auto* imu = std::get_if<ImuSample>(&input)) {
      const std::chrono::duration<double> due(to_seconds(imu->time - kDriveStart) / pace);
      std::this_thread::sleep_until(start + due);
    }
    live.push(input);
  }
  live.stop();
  return lines;
}

// Whether the machine was too busy. The status says so, and then live and replay may differ.
bool is_late(const std::vector<std::string>& told) {
  return count_with(told, "tick not answered") + count_with(told, "not ready after") +
             count_with(told, "joined with later input") >
         0;
}

// As much time for each answer as can be, so that a busy machine answers in time as well.
TEST(LiveEqualsReplay, ToTheLastBit) {
  const Config config =
      default_config({"gpr.latency_budget=1", "smoother.latency=0.19", "graph.latency=5"});
  std::vector<Input> inputs = fixed(there_and_back(1));
  std::swap(inputs[2010], inputs[2040]);  // some come late
  inputs.insert(inputs.begin() + 3000, inputs[2990]);
  inputs.insert(inputs.begin() + 8000, Command{kDriveStart, "explode", ""});
  const Lines replay = replayed(config, inputs);
  EXPECT_GE(replay.corrections(), 3);  // the drive has what a map is made of
  const auto expected = replay.take();
  auto told = lived(config, inputs, kPace).take();
  for (double pace = kPace / 2; is_late(told) && pace >= 1.0; pace /= 2)
    told = lived(config, inputs, pace).take();
  if (is_late(told)) GTEST_SKIP() << "this machine is too busy for answers in time";
  ASSERT_EQ(told.size(), expected.size());
  for (std::size_t i = 0; i < told.size(); ++i) ASSERT_EQ(told[i], expected[i]);
}

}  // namespace
}  // namespace gprodom
