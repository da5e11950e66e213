// Sensors that speak, but lie: messages missing, values that stay, values at their limit, traces
// without a signal.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "gpr/filter/trace_quality.h"
#include "gprodom/types.h"

namespace gprodom {

// Learns the usual time between two messages of a sensor and how much it varies.
class GapWatch {
 public:
  // Whether more than the usual time has passed since the newest message before.
  bool gap_before(TimeNs time);

 private:
  TimeNs newest_ = 0;
  int seen_ = 0;
  double usual_s_ = 0.0, deviation_s_ = 0.0;
};

// Whether a value that usually changes from message to message has stopped to. One that never
// did, as of a coarse sensor at rest, may.
class StuckWatch {
 public:
  // learning_rate: per message, of the share of messages that bring a change.
  StuckWatch(int patience, double learning_rate)
      : patience_(patience), learning_rate_(learning_rate) {}

  // The number of messages in a row without a change is beyond the patience.
  bool stuck(bool changed);

 private:
  int patience_, same_ = 0;
  double learning_rate_;
  double changing_ =
      0.0;  // share of the messages; the least of late, as of a coarse sensor at rest
};

// Whether values are cut off at an end of a range: the greatest of a window comes again and again,
// and more often than the next. (A coarse sensor repeats values too, but the outer ones less.)
class RangeWatch {
 public:
  // True once at the end of a window whose values were cut off.
  bool cut_off(double value);

 private:
  static constexpr std::size_t kWindow = 200;  // messages
  std::vector<double> values_;
};

class ImuWatch {
 public:
  // Empty where the sample is usable, else the reason to drop it.
  std::string check(const ImuSample& sample);

  // What is wrong with the samples of late, the last one included, that are used nevertheless;
  // empty where nothing is.
  std::string quality() const;

 private:
  using Values = Eigen::Matrix<double, 6, 1>;  // acceleration, angular velocity

  Values last_ = Values::Zero();
  StuckWatch all_{20, 0.001};
  std::vector<StuckWatch> axes_{6, StuckWatch(5, 0.001)};
  std::vector<RangeWatch> ranges_{6};
  bool cut_off_ = false;
};

class TraceWatch {
 public:
  // Empty where the trace is usable, else the reason to drop it.
  std::string check(const GprTrace& trace);

  // What is wrong with a trace that the front ends pass over; empty where nothing is.
  std::string quality(const GprTrace& trace);

  // Whether the last one asked about had no signal.
  bool dead() const { return dead_; }

 private:
  std::vector<float> last_;
  StuckWatch stuck_{2, 0.01};
  gpr::TraceCheck check_;
  bool dead_ = false;
};

}  // namespace gprodom
