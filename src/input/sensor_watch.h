// Sensors whose messages arrive but cannot be trusted: missing messages, constant values, values at
// the end of the range, traces without a signal.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "gpr/filter/trace_quality.h"
#include "gprodom/types.h"

namespace gprodom {

inline constexpr char kStuck[] = "values stuck";  // a reason to drop a message

// Detects missing messages: learns the usual time between two messages and its deviation.
class GapWatch {
 public:
  // Whether more than the usual time has passed since the newest message before.
  bool gap_before(TimeNs time);

 private:
  TimeNs newest_ = 0;
  int seen_ = 0;
  double usual_s_ = 0.0, deviation_s_ = 0.0;
};

// Detects a value that usually changes from message to message and has stopped changing. A value
// that rarely changes anyway (a coarse sensor at rest) is not reported.
class StuckWatch {
 public:
  // patience: equal messages in a row. learning_rate: per message, of the share of changing ones.
  StuckWatch(int patience, double learning_rate)
      : patience_(patience), learning_rate_(learning_rate) {}

  // Call for each message. True from `patience` messages without a change on.
  bool stuck(bool changed);

 private:
  int patience_, same_ = 0;
  double learning_rate_;
  double changing_ = 0.0;  // share of messages that changed the value; falls fast, rises slowly
};

// Detects saturation: the largest value of a window comes several times, and much more often than
// the next one. (A coarse sensor repeats values too, but its outer values less often.)
class RangeWatch {
 public:
  // True once, at the end of a window with saturated values.
  bool cut_off(double value);

 private:
  static constexpr std::size_t kWindow = 200;  // messages
  std::vector<double> values_;
};

class ImuWatch {
 public:
  // Empty where the sample is usable, else the reason to drop it.
  std::string check(const ImuSample& sample);

  // What is wrong with recent samples that are used all the same; empty if nothing is.
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
  // Empty where the trace is usable, else the reason to drop it. wheel_m: the newest distance of
  // the wheel. The noise of a receiver changes each trace. Where that was never seen, the ground's
  // changes show whether the traces are stuck, once the wheel has gone so far.
  std::string check(const GprTrace& trace, double wheel_m);
  static constexpr double kGoesFar = 1.0;  // m; some wavelengths of most radars

  // Why the front ends will skip the trace; empty if they will not.
  std::string quality(const GprTrace& trace);

  // Whether the last trace had no signal.
  bool dead() const { return dead_; }

 private:
  std::vector<float> last_;
  double changed_at_m_ = 0.0;  // wheel_m of the first trace like the last one
  StuckWatch stuck_{2, 0.01};
  gpr::TraceCheck check_;
  bool dead_ = false;
};

}  // namespace gprodom
