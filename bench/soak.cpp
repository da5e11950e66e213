// soak LOG.lcmlog HOURS OUT.csv [KEY=VALUE]...: the estimator on a log that is driven again and
// again for HOURS of data time, in one process and on one thread, as fast as it goes. The log
// begins and ends at a standstill: stamps and the wheel's count go on from one round to the next,
// so that it is one long drive.
//
// OUT.csv has a row a minute of data time (a row each ten from the second hour on): hours,
// processor seconds for each second of data, resident memory (bytes), mean and longest solve since
// the row before (ms), way driven (m), revisits that the map trusts and refuses, poses; and
// processor time of a
// yardstick (us), the same small computation each second of data, which is not counted with the
// estimator's. What else the machine does changes both alike, so that their ratio tells whether the
// cost is flat.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "gprodom/lcm_io.h"
#include "io/log_io.h"
#include "live/runner.h"
#include "soak_meter.h"

namespace {

using namespace gprodom;

bool is_sensor(const Input& input) {
  return std::holds_alternative<ImuSample>(input) || std::holds_alternative<WheelSample>(input) ||
         std::holds_alternative<GprTrace>(input);
}

std::vector<Input> read_log(const ChannelConfig& channels, const std::string& path) {
  std::vector<Input> inputs;
  LogReader reader(path);
  while (const lcm::LogEvent* event = reader.next()) {
    auto input = decode_input(channels, event->channel, event->data,
                              static_cast<std::size_t>(event->datalen));
    if (input && is_sensor(*input)) inputs.push_back(std::move(*input));
  }
  if (inputs.empty()) throw std::runtime_error(path + ": no IMU, wheel or radar messages");
  return inputs;
}

TimeNs& time_of(Input& input) {
  if (auto* imu = std::get_if<ImuSample>(&input)) return imu->time;
  if (auto* wheel = std::get_if<WheelSample>(&input)) return wheel->time;
  return std::get<GprTrace>(input).time;
}

// What is told of the time since the row before.
class Rows {
 public:
  explicit Rows(const std::string& path) : out_(path) {
    out_ << "hours,cpu_per_s,resident_bytes,solve_ms,longest_solve_ms,distance_m,revisits,refused,"
            "poses,"
            "yardstick_us\n";
  }

  void take(const Outputs& outputs) {
    poses_ += static_cast<std::int64_t>(outputs.odometry.size());
    if (!outputs.odometry.empty()) distance_m_ = outputs.odometry.back().distance_m;
    for (const Status& status : outputs.status) {
      const auto name =
          std::find(status.names.begin(), status.names.end(), std::string("revisits.refused"));
      if (name != status.names.end()) {
        refused_ = static_cast<int>(
            status.values[static_cast<std::size_t>(std::distance(status.names.begin(), name))]);
      }
    }
    if (!outputs.corrections.empty()) revisits_ = outputs.corrections.back().revisits;
  }

  void measure_machine() { yardstick_.measure(); }

  void write(double data_s, const WorkTime& solver) {
    const double cpu = processor_s() - yardstick_.spent_s();
    const auto jobs = static_cast<double>(std::max<std::int64_t>(1, solver.jobs - before_.jobs));
    out_ << data_s / 3600 << ',' << (cpu - cpu_) / (data_s - data_s_) << ',' << resident_bytes()
         << ',' << 1e3 * (solver.total_s - before_.total_s) / jobs << ',' << 1e3 * solver.longest_s
         << ',' << distance_m_ << ',' << revisits_ << ',' << refused_ << ',' << poses_ << ','
         << 1e6 * yardstick_.take_mean_s() << std::endl;
    cpu_ = cpu;
    data_s_ = data_s;
    before_ = solver;
  }

 private:
  std::ofstream out_;
  double cpu_ = processor_s(), data_s_ = 0.0, distance_m_ = 0.0;
  WorkTime before_;
  Yardstick yardstick_;
  int revisits_ = 0, refused_ = 0;
  std::int64_t poses_ = 0;
};

void run(const Config& config, const std::string& log, double hours, const std::string& out) {
  std::vector<Input> inputs = read_log(config.channels, log);
  const TimeNs first = time_of(inputs.front());
  const TimeNs round = time_of(inputs.back()) - first + from_seconds(0.005);
  double round_m = 0.0;
  for (const Input& input : inputs)
    if (const auto* wheel = std::get_if<WheelSample>(&input)) round_m = wheel->distance_m;

  Runner runner(config, Execution::kInline);
  Rows rows(out);
  const TimeNs end = first + from_seconds(3600 * hours);
  TimeNs next_row = first + from_seconds(60), next_yardstick = first;
  double rounds = 0.0;
  for (TimeNs begun = first; begun < end; begun += round, rounds += 1.0) {
    for (const Input& kept : inputs) {
      Input input = kept;
      const TimeNs time = time_of(input) += begun - first;
      if (time >= end) break;
      if (auto* wheel = std::get_if<WheelSample>(&input)) wheel->distance_m += rounds * round_m;
      rows.take(runner.feed(input));
      if (time >= next_yardstick) {
        rows.measure_machine();
        next_yardstick += from_seconds(1);
      }
      if (time < next_row) continue;
      rows.write(to_seconds(time - first), runner.timing().solver);
      next_row = time + from_seconds(time - first < from_seconds(3600) ? 60 : 600);
      std::fprintf(stderr, "\rsoak %.2f of %.2f h", to_seconds(time - first) / 3600, hours);
    }
  }
  std::fprintf(stderr, "\n");
}

}  // namespace

int main(int argc, char** argv) {
  const double hours = argc >= 4 ? std::atof(argv[2]) : 0.0;
  if (!(hours > 0 && hours <= 1000)) {
    std::cerr << "usage: soak LOG.lcmlog HOURS OUT.csv [KEY=VALUE]...\n";
    return 2;
  }
  try {
    run(gprodom::default_config(std::vector<std::string>(argv + 4, argv + argc)), argv[1], hours,
        argv[3]);
  } catch (const std::exception& error) {
    std::cerr << "soak: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
