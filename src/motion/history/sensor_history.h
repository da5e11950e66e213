// The samples of each sensor over the last seconds, ordered by stamp, and values between two times.
#pragma once

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

class ImuHistory {
 public:
  // Late samples are sorted in by their stamp. Body axes. false: there is already one of that
  // stamp.
  bool insert(const ImuSample& sample);
  void divide_forces(double accel_scale);
  void turn(const Eigen::Matrix3d& R_new_old);  // to other axes
  void forget_before(TimeNs time);  // keeps the last sample before it, to interpolate from
  TimeNs oldest() const { return samples_.empty() ? 0 : samples_.front().time; }
  std::vector<ImuSample> between(TimeNs from, TimeNs to) const;
  // The last `count` of those up to a time, or as many as there are.
  std::vector<ImuSample> last(std::size_t count, TimeNs to) const;

  // The samples round a time.
  std::optional<std::pair<ImuSample, ImuSample>> around(TimeNs time) const;

  // Steps from one sample to the next, cut at `from` and `to` exactly, each with the mean of its
  // ends. Steps across more than max_gap without samples, gap() if it is 0, are marked as bridged.
  std::vector<MotionStep> steps(TimeNs from, TimeNs to, TimeNs max_gap = 0) const;

 private:
  // Without samples for longer, the values held are no measurement. Of a slow IMU two lost samples
  // are no gap yet, also where stamps jitter by a fifth of the period.
  TimeNs gap() const;

  std::deque<ImuSample> samples_;
  TimeNs period_ = 0;  // about the median
};

class WheelHistory {
 public:
  // m/s; nothing that drives gains more between two samples, even if some were lost: half a second
  // at 1 g, which is what tyres can do.
  static constexpr double kGainsMost = 5.0;

  // max_speed: m/s, of the vehicle; 0: learnt. gains_most: that between two samples, while it is
  // learnt.
  explicit WheelHistory(double max_speed, double gains_most = kGainsMost)
      : max_speed_(max_speed), gains_most_(gains_most) {}

  // Starts from a sample of an earlier run. The gap after it counts as covered, however long.
  void resume(const WheelSample& sample);

  // false: faster than this vehicle can be, as after a corrupt count, or if the encoder was set to
  // zero. The distance then continues without the increment, and its time counts as not covered.
  bool insert(const WheelSample& sample);

  // Whether a jump has been found since the last call. A single increment may be the first of a
  // vehicle that is heard at speed, so unless max_speed is given it is the next one that shows it.
  bool take_jump() { return std::exchange(jump_found_, false); }
  void forget_before(TimeNs time);

  // Signed distance, linear between samples; nullopt outside the data and across jumps, and across
  // gaps unless `across_gaps` (an encoder counts on while no message arrives).
  std::optional<double> distance(TimeNs time, bool across_gaps = false) const;

  // Whether a jump of the distance is known after that time.
  bool jumped_since(TimeNs time) const;

  // Stamp of the newest sample of at most `time`; nullopt without one.
  std::optional<TimeNs> newest(TimeNs time) const;

  // The encoder's own count at a time; nullopt as above.
  std::optional<double> reported(TimeNs time) const;

  // s, for which a value is usually repeated while the wheel turns: some drivers send the old value
  // until there is a new one.
  double held_s() const { return std::max(0.0, changes_every_s_ - period_s_); }

  // Unsigned distance over the samples of [from, to]; 0 without samples.
  double path(TimeNs from, TimeNs to) const;

  // The earliest time, `from` or later, since which the path is within `most_m`.
  TimeNs still_since(TimeNs from, double most_m) const;
  // From the first sample at `from` or later up to the last one before the path exceeds `most_m`;
  // empty without samples.
  std::pair<TimeNs, TimeNs> still_from(TimeNs from, double most_m) const;

 private:
  static constexpr TimeNs kMaxGap = 300'000'000;  // ns
  struct Entry {
    TimeNs time;
    double reported, distance_m;
    bool jumped;  // since the entry before
  };
  void watch_repeats(const Entry& before, TimeNs time, double speed);
  std::optional<double> value(TimeNs time, double Entry::*member, bool across_gaps) const;

  double fastest() const;
  bool plausible(double speed);

  double max_speed_, gains_most_;
  bool jump_found_ = false;
  double usual_speed_ = 0.0;                       // m/s, running mean; twice that is plausible
  int fast_in_a_row_ = 0;                          // implausible increments of about equal speed
  double fast_speed_ = 0.0;                        // m/s, of the last of them
  TimeNs changed_at_ = 0;                          // when the speed last changed
  double changed_to_ = 0.0;                        // m/s
  double changes_every_s_ = 0.0, period_s_ = 0.0;  // usual times between changes, samples
  TimeNs resumed_at_ = -1;  // time of the entry after which any gap is covered
  std::deque<Entry> entries_;
};

// Fills in the signed wheel distance of each step; the first begins at `from`. `across_gaps`: the
// distance over a gap of the wheel is spread evenly. false, and zeros, if the wheel does not cover
// all steps.
bool set_wheel_distances(std::vector<MotionStep>& steps, const WheelHistory& wheel, TimeNs from,
                         bool across_gaps);

}  // namespace gprodom
