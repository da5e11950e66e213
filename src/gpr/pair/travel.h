// How far the robot has driven along its track, and turned, over time: the motion that a pair of
// antennas is matched with. It comes from the estimator, and is corrected by what the pair finds.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/pair_way.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

class Travel {
 public:
  using Point = WayPoint;

  Travel() = default;
  explicit Travel(std::vector<Point> points) : points_(std::move(points)) {}

  // Replaces the points from the first of these on, which are in order of time. Their distances
  // and headings are shifted so that the path continues.
  void revise(const std::vector<Point>& newest);
  void append(const Point& point) { points_.push_back(point); }
  void forget_before(TimeNs time);

  // The speed at its end, m/s, and its standard deviation: how far the path can be believed.
  // by_wheel: its shape is a wheel's, so it is wrong by a factor that changes slowly.
  void set_speed(double speed_mps, double sigma_mps, bool by_wheel) {
    speed_mps_ = speed_mps;
    speed_sigma_mps_ = sigma_mps;
    by_wheel_ = by_wheel;
  }
  bool by_wheel() const { return by_wheel_; }
  double speed_mps() const { return speed_mps_; }
  double speed_sigma_mps() const { return speed_sigma_mps_; }

  bool empty() const { return points_.empty(); }
  const std::vector<Point>& points() const { return points_; }

  // Constant beyond the ends. Must not be empty.
  double at(TimeNs time) const;  // distance (m), cubic between points
  double heading_at(TimeNs time) const;

 private:
  std::vector<Point> points_;  // in order of time
  double speed_mps_ = 0.0, speed_sigma_mps_ = 0.0;
  bool by_wheel_ = false;
};

// The last part of a path on which the robot has not turned back. Distances grow with time: those
// of a robot that drives backwards are negated.
class Run {
 public:
  // scale: all distances are multiplied by it, where the path is not believed.
  Run(const Travel& travel, TimeNs now, double scale = 1.0);

  // At a constant speed (m/s; negative: backwards) during the last `seconds`, where nothing is
  // known of the path but how it turns.
  Run(const Travel& travel, TimeNs now, double speed_mps, double seconds);
  bool steady() const { return steady_; }
  // The same way in the other direction: what antennas see whose order is the opposite.
  Run mirrored() const;
  static constexpr TimeNs kLongestSteady = 10'000'000'000;  // ns

  int direction() const { return direction_; }  // 1 forwards, -1 backwards
  bool is_mirrored() const { return mirrored_; }
  TimeNs begin() const { return points_.front().time; }
  double length() const { return points_.back().s_m - points_.front().s_m; }
  double newest() const { return points_.back().s_m; }

  double at(TimeNs time) const;
  // When the robot passed it; within the run.
  TimeNs time_at(double s_m) const;
  // m, in the plane, between the place of one part of the robot at time `from` and that of another
  // at time `to`, if the path in between is `scale` times as long; the parts in body.
  double apart(TimeNs from, const Eigen::Vector3d& part_from, TimeNs to,
               const Eigen::Vector3d& part_to, double scale) const;

 private:
  int direction_ = 1;
  bool steady_ = false, mirrored_ = false;
  std::vector<Travel::Point> points_;
};

}  // namespace gprodom::gpr
