#include "gpr/pair/travel.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace gprodom::gpr {

namespace {

constexpr TimeNs kStep = 50'000'000;  // ns, between the points of a run
// m; the estimate of a standing or shaken robot goes back by less.
constexpr double kTurnsBack = 0.02;

bool before(const Travel::Point& point, TimeNs time) { return point.time < time; }

// Linear between points, constant beyond the ends.
double value_at(const std::vector<Travel::Point>& points, TimeNs time,
                double Travel::Point::*value) {
  const auto after = std::lower_bound(points.begin(), points.end(), time, before);
  if (after == points.begin()) return points.front().*value;
  if (after == points.end()) return points.back().*value;
  const Travel::Point &a = *(after - 1), &b = *after;
  return a.*value + (b.*value - a.*value) * static_cast<double>(time - a.time) /
                        static_cast<double>(b.time - a.time);
}

double heading_of(const std::vector<Travel::Point>& points, TimeNs time) {
  return value_at(points, time, &Travel::Point::heading_rad);
}

}  // namespace

void Travel::revise(const std::vector<Point>& newest) {
  if (newest.empty()) return;
  const Point& first = newest.front();
  const double shift = points_.empty() ? 0.0 : at(first.time) - first.s_m;
  const double turn = points_.empty() ? 0.0 : heading_at(first.time) - first.heading_rad;
  const auto from = std::lower_bound(points_.begin(), points_.end(), newest.front().time, before);
  points_.erase(from, points_.end());
  for (const Point& point : newest)
    points_.push_back({point.time, point.s_m + shift, point.heading_rad + turn});
}

void Travel::forget_before(TimeNs time) {
  points_.erase(points_.begin(), std::lower_bound(points_.begin(), points_.end(), time, before));
}

double Travel::heading_at(TimeNs time) const { return heading_of(points_, time); }

double Travel::at(TimeNs time) const {
  const auto after = std::lower_bound(points_.begin(), points_.end(), time, before);
  if (after == points_.begin()) return points_.front().s_m;
  if (after == points_.end()) return points_.back().s_m;
  const auto i = static_cast<std::size_t>(after - points_.begin()) - 1;
  const Point &a = points_[i], &b = points_[i + 1];
  const double dt = static_cast<double>(b.time - a.time),
               u = static_cast<double>(time - a.time) / dt;
  // Slopes by the neighbours (Catmull-Rom), times dt.
  const auto slope = [&](std::size_t from, std::size_t to) {
    return (points_[to].s_m - points_[from].s_m) * dt /
           static_cast<double>(points_[to].time - points_[from].time);
  };
  const double ma = slope(i == 0 ? 0 : i - 1, i + 1);
  const double mb = slope(i, std::min(i + 2, points_.size() - 1));
  const double u2 = u * u, u3 = u2 * u;
  return a.s_m * (2 * u3 - 3 * u2 + 1) + ma * (u3 - 2 * u2 + u) + b.s_m * (3 * u2 - 2 * u3) +
         mb * (u3 - u2);
}

Run::Run(const Travel& travel, TimeNs now, double scale) {
  std::vector<Travel::Point> back;  // newest first
  const TimeNs oldest = travel.points().front().time;
  double least = 0, most = 0;
  for (TimeNs time = now; time >= oldest; time -= kStep) {
    const double s = travel.at(time);
    if (back.empty()) least = most = s;
    // The direction is that of the last kTurnsBack; then the run ends where the path goes beyond
    // its extreme by as much again.
    const bool decided = most - least > kTurnsBack;
    if (!decided) {
      least = std::min(least, s);
      most = std::max(most, s);
      if (most - least > kTurnsBack) direction_ = s == least ? 1 : -1;
    } else if (direction_ > 0 ? s > least + kTurnsBack : s < most - kTurnsBack) {
      break;
    } else {
      least = std::min(least, s);
      most = std::max(most, s);
    }
    back.push_back({time, s, travel.heading_at(time)});
  }
  points_.assign(back.rbegin(), back.rend());
  // The part before the extreme point belongs to the way in the other direction.
  const auto first = std::min_element(points_.begin(), points_.end(),
                                      [&](const Travel::Point& a, const Travel::Point& b) {
                                        return direction_ * a.s_m < direction_ * b.s_m;
                                      });
  points_.erase(points_.begin(), first);
  double reached = direction_ * points_.front().s_m;
  for (Travel::Point& point : points_)
    point.s_m = reached = std::max(reached, direction_ * point.s_m);
  for (Travel::Point& point : points_) point.s_m *= scale;
}

Run::Run(const Travel& travel, TimeNs now, double speed_mps, double seconds)
    : direction_(speed_mps < 0 ? -1 : 1), steady_(true) {
  const TimeNs begin = now - from_seconds(seconds);
  for (TimeNs time = begin;; time = std::min(time + kStep, now)) {
    points_.push_back(
        {time, std::abs(speed_mps) * to_seconds(time - begin), travel.heading_at(time)});
    if (time == now) break;
  }
}

Run Run::mirrored() const {
  Run other = *this;
  other.direction_ = -direction_;
  other.mirrored_ = !mirrored_;
  return other;
}

double Run::at(TimeNs time) const { return value_at(points_, time, &Travel::Point::s_m); }

TimeNs Run::time_at(double s_m) const {
  const auto after =
      std::lower_bound(points_.begin(), points_.end(), s_m,
                       [](const Travel::Point& point, double s) { return point.s_m < s; });
  if (after == points_.begin()) return points_.front().time;
  if (after == points_.end()) return points_.back().time;
  const Travel::Point &a = *(after - 1), &b = *after;
  return a.time + static_cast<TimeNs>((s_m - a.s_m) / (b.s_m - a.s_m) *
                                      static_cast<double>(b.time - a.time));
}

double Run::apart(TimeNs from, const Eigen::Vector3d& part_from, TimeNs to,
                  const Eigen::Vector3d& part_to, double scale) const {
  const double heading = heading_of(points_, from);
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();  // in body at time `from`
  TimeNs a = from;
  while (a < to) {
    const TimeNs b = std::min(a + kStep, to);
    const double way = (mirrored_ ? -direction_ : direction_) * (at(b) - at(a));
    const double turned = heading_of(points_, a + (b - a) / 2) - heading;
    moved += way * Eigen::Vector2d(std::cos(turned), std::sin(turned));
    a = b;
  }
  const Eigen::Rotation2Dd turned(heading_of(points_, to) - heading);
  return (scale * moved + turned * part_to.head<2>() - part_from.head<2>()).norm();
}

}  // namespace gprodom::gpr
