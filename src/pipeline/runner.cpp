#include "pipeline/runner.h"

#include <utility>

namespace gprodom {

bool Results::empty() const {
  return outputs.odometry.empty() && outputs.displacements.empty() && outputs.corrections.empty() &&
         outputs.sfm.empty() && outputs.status.empty() && outputs.warnings.empty();
}

Runner::Runner(const Config& config, Execution execution)
    : command_channel_(config.channels.command),
      saved_scale_(config.state),
      odometry_(saved_scale_.taken_up(config, notices_), execution) {}

Results Runner::feed(const Input& input) {
  struct Adder {
    Runner& runner;
    void operator()(const ImuSample& sample) const { runner.odometry_.add(sample); }
    void operator()(const WheelSample& sample) const { runner.odometry_.add(sample); }
    void operator()(const GprTrace& trace) const { runner.odometry_.add(trace); }
    void operator()(const Displacement& external) const { runner.odometry_.add(external); }
    void operator()(const Command& command) const { runner.obey(command); }
    void operator()(const Rejection& r) const { runner.reject(r.channel, r.reason); }
  };
  std::visit(Adder{*this}, input);
  return step();
}

Results Runner::step() { return place(odometry_.step()); }

Results Runner::finish() { return place(odometry_.finish()); }

void Runner::reset() { odometry_.reset(); }

void Runner::reject(const std::string& channel, const std::string& reason) {
  odometry_.reject(channel, reason);
}

void Runner::obey(const Command& command) {
  if (command.name == "reset") {
    reset();
    notices_.emplace_back("reset by command: the estimator starts afresh at its initialiser");
  } else {
    reject(command_channel_, "unknown command, expected reset");
  }
}

Results Runner::place(Outputs outputs) {
  Results results;
  if (!outputs.odometry.empty()) {
    std::string trouble = saved_scale_.save(outputs.odometry.back());
    if (!trouble.empty()) notices_.push_back(std::move(trouble));
  }
  results.outputs = std::move(outputs);
  auto& warnings = results.outputs.warnings;
  warnings.insert(warnings.begin(), notices_.begin(), notices_.end());
  notices_.clear();
  return results;
}

}  // namespace gprodom
