// Detects sudden slip: compares the wheel's distance with the published velocity over a short
// window.
//
// The velocity is the newest solved one, predicted with the IMU, so it does not follow the wheel
// until the next solution. When a slip begins, the wheel's speed jumps and the robot's does not.
// The slip lasts until both agree. At the end of a slip that was not detected, the published
// velocity is the wrong one. Wheel and velocity then disagree, and the radar's coherence decides
// between them.
#pragma once

#include <deque>
#include <limits>
#include <optional>

#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "motion/history/path_history.h"
#include "motion/history/sensor_history.h"
#include "motion/slip/error_tail.h"

namespace gprodom {

enum class WheelSlip { kNone, kFast, kSlow };  // the wheel against the ground

// What has been learnt about the wheel.
struct WheelError {
  double noise = 0.0;    // m/sqrt(m), learnt from left and right wheels; 0: not learnt
  double sigma_m = 0.0;  // standard deviation of the distance of an interval; 0: not learnt
  double floor_m = 0.0;  // of any distance, by the encoder's resolution
  double late_s = 0.0;   // how long its values are held, or delayed against the IMU
};

class SlipWatch {
 public:
  // ns; a slip can be revoked this far back, so the wheel's history must reach this far.
  static constexpr TimeNs kMemory = 8'000'000'000;

  // window_s: length of the smoother's window.
  SlipWatch(const WheelConfig& config, double window_s);

  // Call with every published estimate. `wheel_now` is the newest stamp in `wheel`. `speed_known`:
  // the speed is known from other sensors than the wheel. If it is not, as after a gap of the IMU,
  // the published velocity cannot show slip, and earlier detections are dropped.
  void add(const OdometryEstimate& estimate, const WheelHistory& wheel, TimeNs wheel_now,
           bool speed_known);

  WheelSlip now() const { return now_; }

  // Takes an unsigned distance (m) by the radar. Used while the wheel counts as slipping, and while
  // the speed is not known.
  void compare_with_radar(const Displacement& radar, const WheelHistory& wheel, double wheel_scale);

  // The speed of the state at `time` if the published velocity was found to be wrong; returned
  // once.
  //  - The wheel counted as slipping, but the radar has agreed with it for two seconds: the wheel's
  //    speed.
  //  - The speed is not known, and a distance of the radar disagrees with the published one: the
  //    wheel's speed if the radar agrees with the wheel, otherwise the radar's.
  std::optional<SpeedCorrection> take_speed_correction(TimeNs time, const WheelHistory& wheel,
                                                       double wheel_scale);

  // Also makes the window long enough for two held values.
  // m, y of body: where the wheel is.
  void set_wheel_position(double y_m) { config_.lever_arm.y() = y_m; }
  void set_wheel_error(const WheelError& error);

  // Signed distance (m) by the published velocity; nothing where that is not known.
  std::optional<double> ground(TimeNs from, TimeNs to) const;

  // Whether any window with slip overlaps (from, to), of those that the wheel's samples up to
  // `heard` have shown.
  bool between(TimeNs from, TimeNs to, TimeNs heard = std::numeric_limits<TimeNs>::max()) const;

 private:
  struct Interval {
    TimeNs from, to;
    TimeNs found = 0;  // stamp of the wheel's sample that showed it first
  };

  struct Distances {
    double wheel_m, ground_m;  // signed; ground as published
    double by_delay_m;         // difference that the delay of the wheel explains
  };

  // The published velocity was found wrong while the speed is not known.
  struct SpeedError {
    TimeNs since;
    bool wheel_right;
    double speed_change = 0.0, sigma = 0.0;  // m/s, signed; used if the wheel is wrong too
  };

  std::optional<Distances> distances(TimeNs from, TimeNs to, const WheelHistory& wheel,
                                     double wheel_scale) const;
  static double share_of(const Distances& moved);  // that slips
  double variance(const OdometryEstimate& estimate, const Distances& moved) const;
  WheelSlip judge(const Distances& moved, double variance) const;
  void learn_tail(TimeNs time, WheelSlip seen, const Distances& moved, double variance);
  void follow_share(TimeNs time, double share);
  void judge_by_radar_alone(const Displacement& radar, const WheelHistory& wheel,
                            double wheel_scale);
  void mark(TimeNs from, TimeNs to);

  WheelConfig config_;
  TimeNs smoother_window_, window_;
  double wheel_sigma_m_, wheel_floor_m_, pair_noise_ = 0.0;
  TimeNs late_ = 0;               // possible delay of the wheel's distance
  PathHistory track_;             // of the wheel's contact point, signed, as published
  std::deque<Interval> slipped_;  // disjoint, oldest first
  TimeNs judged_ = 0;             // stamp of the wheel sample that now_ is about
  WheelSlip now_ = WheelSlip::kNone;
  struct Share {
    TimeNs time;
    double value;
  };
  std::deque<Share> shares_;  // that slipped, over the last moments of the present slip
  ErrorTail tail_;
  TimeNs tail_time_ = 0;      // end of the interval that it has seen last
  bool jumped_back_ = false;  // in the present slip
  double largest_share_ = 0.0;
  TimeNs began_ = 0;  // the present slip
  // The wheel was silent. It may return in mid-slip, without the jump that shows an onset, so it is
  // not used until it agrees with the velocity.
  bool back_from_silence_ = false;
  Interval radar_agrees_{0, 0};  // the radar has agreed with the wheel all through it

  bool speed_known_ = true;
  // While the speed is not known: the wheel's slip according to the radar, and the error that the
  // next correction removes.
  WheelSlip slip_by_radar_ = WheelSlip::kNone;
  std::optional<SpeedError> speed_error_;
};

}  // namespace gprodom
