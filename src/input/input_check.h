// Decides which messages can be used. Reports what is wrong with the others to the health.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "gprodom/config.h"
#include "gprodom/position_fix.h"
#include "gprodom/types.h"
#include "input/clock_watch.h"
#include "input/health.h"
#include "input/sensor_watch.h"
#include "input/time_guard.h"
#include "input/trace_format_watch.h"
#include "input/trigger_watch.h"

namespace gprodom {

using InputMessage =
    std::variant<ImuSample, WheelSample, WheelsSample, GprTrace, Displacement, PositionFix>;

class InputCheck {
 public:
  // `health` outlives this.
  InputCheck(const Config& config, Health& health);

  // Whether the message is usable. The reason to drop it, or a weakness of a usable one, goes to
  // the health. The stamps of a usable message are changed to the estimator's time: with the
  // sensor's time offset, and continued if the clock was set.
  bool accept(InputMessage& message);

  // The IMU's clock alone was set ahead, so the present estimate refers to another time.
  bool clock_moved() const { return time_guard_.moved(); }

  // The sensors' own stamp of a time of the estimator.
  TimeNs sensor_stamp(TimeNs time) const { return time_guard_.sensor_stamp(time); }

  // Newest stamp accepted of the IMU, which is the estimator's clock, and of the wheel.
  TimeNs imu_now() const { return imu_now_; }
  TimeNs wheel_now() const { return wheel_now_; }

  // The setting of the radar, once several traces of its first antenna agree in it; or of the one
  // in its place, while there was none.
  std::optional<TraceFormat> trace_format() const;

  // The channel of the wheel: that of left and right wheels, if they send.
  const std::string& wheel_channel() const;

  // What makes a trace: kTime or kDistance; kAuto while that is not known.
  Trigger trigger() const { return trigger_.trigger(); }

  // No trace for a second, of the antenna that the estimator follows. Of traces by distance, and
  // while it is not known whether they are: though the robot has driven on.
  bool radar_silent() const;

  // The first of gpr.antennas, otherwise the one whose trace came first; nothing before.
  const std::optional<int>& antenna() const { return antenna_; }

  // The antenna that the estimator follows: the same, or while that one is gone another one.
  const std::optional<int>& followed() const { return deputy_ ? deputy_ : antenna_; }

  // Reports sensors that are silent or have no signal.
  void watch_silence(bool radar_used);

  // While the IMU is silent nothing else is published. So this gives a status that says so, once a
  // second of the other sensors' time.
  std::optional<Status> status_without_clock();

 private:
  static constexpr std::size_t kMessages = std::variant_size_v<InputMessage>;

  // What is known about the traces of one antenna.
  struct Antenna {
    TraceFormatWatch format;
    TraceWatch quality;
    GapWatch gaps;
    TimeNs newest = 0;  // trace
    TimeNs since = 0;   // first one with a signal after the last gap
    TimeNs signal = 0;  // newest one that was not dead
    TimeNs stuck = 0;   // newest one that was dropped as stuck
  };

  std::string refusal(InputMessage& message);
  std::string refusal(const GprTrace& trace);
  bool is_other_antenna(const InputMessage& message) const;
  void watch(const InputMessage& message);
  bool is_silent(TimeNs newest_trace) const;
  void choose_antenna();
  void note_outage(const PositionFix& fix);

  const Config& config_;
  Health& health_;
  TimeGuard time_guard_;
  ImuWatch imu_watch_;
  std::optional<int> antenna_;
  std::optional<int> deputy_;  // another antenna, in its place
  TimeNs first_imu_ = 0;
  std::map<int, Antenna> antennas_;  // by id
  TriggerWatch trigger_;
  std::array<GapWatch, kMessages> gaps_;      // by the message's index
  std::array<ClockWatch, kMessages> clocks_;  // likewise
  TimeNs imu_now_ = 0, wheel_now_ = 0;
  bool pair_heard_ = false;
  // Stamps of the first fix without a position since the last one with it (0: there is none), and
  // of the newest fix.
  TimeNs outage_begin_ = 0, outage_now_ = 0;
  TimeNs imu_stuck_ = 0;  // newest sample that was dropped as stuck
  double wheel_m_ = 0.0;  // newest distance; of a pair the mean
  TimeNs next_lost_status_ = 0;
};

}  // namespace gprodom
