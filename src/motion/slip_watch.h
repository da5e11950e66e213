// Slip of the wheel: what it reports against what the published velocity says, over a short window.
//
// The velocity is the newest solved one carried on by the IMU, so it does not follow the wheel for
// the time that a solve is behind. At the onset of a slip the wheel's speed jumps and the robot's
// does not; over a long slip the velocity's own variance grows and the wheel is believed again. At
// the end of a slip that went unseen it is the published velocity that is wrong: two witnesses
// against each other, between which the radar's coherence decides.
#pragma once

#include <deque>
#include <optional>

#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "motion/path_history.h"
#include "motion/sensor_history.h"

namespace gprodom {

enum class WheelSlip { kNone, kFast, kSlow };  // the wheel against the ground

// What has been learnt of the wheel.
struct WheelError {
  double noise = 0.0;    // m/sqrt(m), as left and right show it; 0: they do not
  double sigma_m = 0.0;  // standard deviation of a distance; below wheel.noise_floor: that
  double late_s = 0.0;   // how long its values are held, or come behind the IMU
};

class SlipWatch {
 public:
  // ns; as far back as a slip can be taken back, for which the wheel's history is needed.
  static constexpr TimeNs kMemory = 8'000'000'000;

  explicit SlipWatch(const WheelConfig& config);

  // Call with every estimate published. `wheel_now` is the newest stamp in `wheel`. `speed_known`:
  // otherwise than by the wheel. Where it is not, as after a gap of the IMU, the published velocity
  // is no witness against the wheel, and what was judged before is forgotten.
  void add(const OdometryEstimate& estimate, const WheelHistory& wheel, TimeNs wheel_now,
           bool speed_known);

  WheelSlip now() const { return now_; }

  // How far the radar says that the robot moved (m, unsigned). It is compared while the wheel is
  // taken for slipping, and while the speed is not known.
  void compare_with_radar(const Displacement& radar, const WheelHistory& wheel, double wheel_scale);

  // The speed of the state at `time`, where the published velocity was found wrong; told once.
  //  - The wheel was taken for slipping, and the radar has agreed with it for two seconds: the
  //    wheel's speed is right.
  //  - The speed is not known, and one distance of the radar disagrees with the published one: the
  //    wheel's speed where the radar agrees with the wheel, else the radar's.
  //  - The speed is not known, the radar says nothing, and the wheel has for 0.6 s turned more
  //  slowly
  //    than the published speed: the wheel's speed.
  std::optional<SpeedCorrection> take_speed_correction(TimeNs time, const WheelHistory& wheel,
                                                       double wheel_scale);

  // The window reaches over two held values at least.
  void set_wheel_error(const WheelError& error);

  // How far the robot came (m, signed) by the published velocity; nothing where that is not known.
  std::optional<double> ground(TimeNs from, TimeNs to) const;

  // Whether any window that showed slip reaches into (from, to).
  bool between(TimeNs from, TimeNs to) const;

 private:
  struct Interval {
    TimeNs from, to;
  };

  struct Distances {
    double wheel_m, ground_m;  // signed; ground as published
    double by_delay_m;         // what the ground's would be off by if the wheel is late
  };

  // The published velocity was found wrong while the speed is not known.
  struct SpeedError {
    TimeNs since;
    bool wheel_right;
    double faster = 0.0, sigma = 0.0;  // m/s, signed, of the robot; where the wheel is wrong too
  };

  std::optional<Distances> distances(TimeNs from, TimeNs to, const WheelHistory& wheel,
                                     double wheel_scale) const;
  WheelSlip judge(const OdometryEstimate& estimate, const Distances& moved) const;
  void judge_by_radar_alone(const Displacement& radar, const WheelHistory& wheel,
                            double wheel_scale);
  void doubt_speed(WheelSlip seen, TimeNs time);
  void mark(TimeNs from, TimeNs to);

  WheelConfig config_;
  TimeNs window_;
  double wheel_sigma_m_, pair_noise_ = 0.0;
  TimeNs late_ = 0;               // by which the wheel's distance may trail
  PathHistory track_;             // of the wheel's contact point, signed, as published
  std::deque<Interval> slipped_;  // apart from each other, oldest first
  TimeNs judged_ = 0;             // the wheel sample that now_ is about
  WheelSlip now_ = WheelSlip::kNone;
  // The wheel was silent: it may come back in mid-slip, without the jump that tells an onset, and
  // is not believed before it agrees.
  bool back_from_silence_ = false;
  Interval radar_agrees_{0, 0};  // with the wheel, without a break

  bool speed_known_ = true;
  // While the speed is not known: since when the wheel turns more slowly (0: it does not), what the
  // radar says of it, and the error that the next correction takes out.
  TimeNs slow_since_ = 0;
  WheelSlip radar_says_ = WheelSlip::kNone;
  std::optional<SpeedError> speed_error_;
};

}  // namespace gprodom
