// Slip of the wheel: what it reports against what the published velocity says, over a short window.
//
// The velocity is the newest solved one carried on by the IMU, so it does not follow the wheel for
// the time that a solve is behind. At the onset of a slip the wheel's speed jumps and the robot's
// does not; over a long slip the velocity's own variance grows and the wheel is believed again.
#pragma once

#include <deque>

#include "gprodom/config.h"
#include "gprodom/types.h"
#include "pipeline/path_history.h"
#include "pipeline/sensor_history.h"

namespace gprodom {

enum class WheelSlip { kNone, kFast, kSlow };  // the wheel against the ground

class SlipWatch {
 public:
  explicit SlipWatch(const WheelConfig& config);

  // Call with every estimate published. `wheel_now` is the newest stamp in `wheel`.
  void add(const OdometryEstimate& estimate, const WheelHistory& wheel, TimeNs wheel_now);

  WheelSlip now() const { return now_; }

  // Whether any window that showed slip reaches into (from, to).
  bool between(TimeNs from, TimeNs to) const;

 private:
  struct Interval {
    TimeNs from, to;
  };

  WheelSlip judge(const OdometryEstimate& estimate, double wheel_m, double ground_m) const;
  void mark(TimeNs from, TimeNs to);

  WheelConfig config_;
  TimeNs window_;
  PathHistory track_;             // of the wheel's contact point, signed, as published
  std::deque<Interval> slipped_;  // apart from each other, oldest first
  TimeNs judged_ = 0;             // the wheel sample that now_ is about
  WheelSlip now_ = WheelSlip::kNone;
};

}  // namespace gprodom
