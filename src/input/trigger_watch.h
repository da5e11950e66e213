// Whether the radar's traces come by time, or by distance: from a survey wheel, one each so many
// centimetres, and none while the robot stands.
//
// Told by the configuration, or found from what comes at standstills of the wheel. Several traces
// at one standstill come by time. If none came at a standstill, and they come again as soon as the
// wheel has turned a little, they come by distance. A radar that fails does not do so by chance
// often, and the next standstill decides again.
#pragma once

#include <optional>

#include "gprodom/choices.h"
#include "gprodom/types.h"

namespace gprodom {

class TriggerWatch {
 public:
  explicit TriggerWatch(Trigger told) : told_(told) {}

  // Call for each message of the wheel, and for each trace, that is used.
  void add_wheel(TimeNs time, double distance_m);
  void add_trace(TimeNs time);

  // kAuto while it is not known.
  Trigger trigger() const { return told_ == Trigger::kAuto ? found_ : told_; }

  // A trace is due, at the latest, after so much of the way.
  static constexpr double kLeastOften = 0.5;  // m
  bool is_due() const { return rolled_since_trace_m_ > kLeastOften; }

 private:
  static constexpr double kRests_m = 0.005;               // the wheel turns no more at rest
  static constexpr TimeNs kShortestRest = 2'000'000'000;  // that tells
  static constexpr TimeNs kSettles = 500'000'000;         // before the wheel has come to rest
  static constexpr int kEnough = 8;                       // traces at rest
  static constexpr double kLargestJump = 1.0;             // m; of a counter that was set back

  void end_rest(TimeNs time, double distance_m);

  const Trigger told_;
  Trigger found_ = Trigger::kAuto;
  std::optional<double> last_m_;
  double rests_at_m_ = 0.0, rolled_since_trace_m_ = 0.0;
  TimeNs rests_from_ = 0;
  int traces_at_rest_ = 0;
  bool rested_without_ = false;  // the last rest had no traces, and none has come since
};

}  // namespace gprodom
