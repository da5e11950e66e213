#include "map/path/map_path.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/by_time.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr TimeNs kRecent = 20'000'000'000;
constexpr double kTurn = 0.3;  // rad; a turn on the spot by so much makes a node
// A scale with a smaller standard deviation is held, and nothing depends on it.
constexpr double kHeldScaleVariance = 1e-12;
// Least standard deviation of a step, m and rad, so that its covariance stays positive definite.
constexpr double kLeastPosition = 3e-4, kLeastYaw = 3e-5;

PlanarPose planar(const NavState& state) {
  const Vector3d ahead = state.q_odom_body * Vector3d::UnitX();
  return {state.p_odom.head<2>(), std::atan2(ahead.y(), ahead.x())};
}

// The pose that the estimator would have given to `state` with another wheel scale.
PlanarPose with_scale(const PathState& state, double scale) {
  const Vector3d error = state.d_scale * (scale - state.scale);
  return compose({error.head<2>(), error[2]}, state.pose);
}

// On the path without jumps.
PlanarPose on_path(const PathState& state, double scale) {
  return compose(state.path_from_odom, with_scale(state, scale));
}

PlanarPose inverse(const PlanarPose& pose) { return between(pose, {}); }

}  // namespace

PathState path_state(const StateResult& newest) {
  constexpr std::array kRows{row::kP, row::kP + 1, row::kTheta + 2};
  PathState state;
  state.time = newest.state.time;
  state.pose = planar(newest.state);
  state.scale = newest.state.wheel_scale;
  state.covariance = newest.covariance(kRows, kRows);
  const Vector3d with_scale = newest.covariance.col(row::kScale)(kRows);
  const Matrix3d to_pose = lever(state.pose.p);
  state.pose_covariance = to_pose * state.covariance * to_pose.transpose();
  state.pose_covariance.topLeftCorner<2, 2>() += newest.unmodelled_covariance;
  state.slip_sigma = newest.slip_sigma;
  state.unmeasured_slip_sigma = newest.unmeasured_slip_sigma;
  const double variance = newest.covariance(row::kScale, row::kScale);
  if (variance > kHeldScaleVariance) {
    state.d_scale = with_scale / variance;
    state.covariance -= with_scale * with_scale.transpose() / variance;
  }
  return state;
}

void settle(PathState& state, const StateResult& result, const std::optional<PathState>& before) {
  state.pose = planar(*result.settled);
  state.scale = result.state.wheel_scale;
  state.believed_slip_sigma = result.settled_slip_sigma;
  if (result.settled_slip_by_pair)
    state.slip_sigma = std::min(state.unmeasured_slip_sigma, *result.settled_slip_by_pair);
  if (!before) return;
  state.path_from_odom = before->path_from_odom;
  if (result.before_settled && result.before_settled->time == before->time)
    state.path_from_odom =
        compose(on_path(*before, state.scale), inverse(planar(*result.before_settled)));
}

PathState seen_from(const PathState& newer, const PathState& state) {
  PathState seen = state;
  seen.pose = compose(inverse(newer.path_from_odom), on_path(state, newer.scale));
  seen.path_from_odom = newer.path_from_odom;
  seen.scale = newer.scale;
  return seen;
}

PlanarPose way_between(const PathState& a, const PathState& b) {
  return between(on_path(a, b.scale), on_path(b, b.scale));
}

PlanarStep step_between(const PathState& a, const PathState& b) {
  Matrix3d into_a = Matrix3d::Identity();
  into_a.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-a.pose.yaw).toRotationMatrix();
  into_a = into_a * lever(b.pose.p);
  PlanarStep step;
  step.seconds = to_seconds(b.time - a.time);
  step.measured = way_between(a, b);
  step.scale = b.scale;
  step.d_scale = into_a * (b.d_scale - a.d_scale);
  // A standstill reduces earlier errors, so some eigenvalues of the growth may be negative.
  Matrix3d growth = into_a * (b.covariance - a.covariance) * into_a.transpose();
  const Vector3d least(kLeastPosition, kLeastPosition, kLeastYaw);
  const Matrix3d unit = least.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(0.5 * unit * (growth + growth.transpose()) *
                                                      unit);
  const Matrix3d basis = least.asDiagonal() * eigen.eigenvectors();
  step.covariance = basis * eigen.eigenvalues().cwiseMax(1.0).asDiagonal() * basis.transpose();
  return step;
}

PlanarPose along_arc(double along, double curvature) {
  const double turn = curvature * along;
  return {{along, 0.5 * turn * along}, turn};
}

std::optional<PlanarStep> MapPath::add(const PathState& state) {
  Point point{state};
  if (!recent_.empty()) {
    const Point& last = recent_.back();
    const double ahead = way_between(last, state).p.x();
    point.distance_m = last.distance_m + ahead;
    point.travelled_m = last.travelled_m + std::abs(ahead);
    point.slip_m = last.slip_m + state.slip_sigma * std::abs(ahead);
    point.believed_slip_m = last.believed_slip_m + state.believed_slip_sigma * std::abs(ahead);
  }
  recent_.push_back(point);
  while (recent_.front().time + kRecent < state.time) recent_.pop_front();
  if (nodes_.empty()) {
    nodes_.push_back(point);
    return std::nullopt;
  }
  const Point& last = nodes_.back();
  const bool turned = std::abs(wrapped(way_between(last, state).yaw)) > kTurn;
  if (point.travelled_m - last.travelled_m < node_spacing_m_ && !turned) return std::nullopt;
  const PlanarStep to_new = step(last, point);
  nodes_.push_back(point);
  return to_new;
}

// The states of a step share one slip, so their deviations (not variances) add up.
PlanarStep MapPath::step(const Point& a, const Point& b) {
  PlanarStep step = step_between(a, b);
  const double way = b.travelled_m - a.travelled_m;
  step.slip_sigma = way > 0 ? (b.slip_m - a.slip_m) / way : 0.0;
  step.believed_slip_sigma = way > 0 ? (b.believed_slip_m - a.believed_slip_m) / way : 0.0;
  return step;
}

double MapPath::distance_at(TimeNs time) const {
  return interpolated(recent_, time, &Point::distance_m);
}

// way: driven in `seconds` about that time.
MapPath::Mark::Mark(const Point& point, const PlanarPose& way, double seconds)
    : point_(point), velocity_(way.p / seconds), yaw_rate_(way.yaw / seconds) {}

std::optional<MapPath::Mark> MapPath::mark(TimeNs time) const {
  if (recent_.size() < 2 || time < recent_.front().time || time > recent_.back().time)
    return std::nullopt;
  const auto next = std::min(first_after(recent_, time), recent_.end() - 1);
  const Point &a = *(next - 1), &b = *next;
  const double seconds = to_seconds(b.time - a.time);
  const double share = to_seconds(time - a.time) / seconds;
  const auto mean = [share](const auto& from, const auto& to) {
    return from + share * (to - from);
  };
  const PlanarPose way = way_between(a, b);
  Point point = a;  // in odom as `a` has it
  point.time = time;
  point.pose = compose(a.pose, {share * way.p, share * way.yaw});
  point.covariance = a.covariance + share * (b.covariance - a.covariance);
  point.d_scale = a.d_scale + share * (b.d_scale - a.d_scale);
  point.distance_m = mean(a.distance_m, b.distance_m);
  point.travelled_m = mean(a.travelled_m, b.travelled_m);
  point.slip_m = mean(a.slip_m, b.slip_m);
  point.believed_slip_m = mean(a.believed_slip_m, b.believed_slip_m);
  return Mark(point, way, seconds);
}

PlanarStep MapPath::way(const Mark& a, const Mark& b) { return step(a.point_, b.point_); }

MapPath::MarkAtNode MapPath::at_node(const Mark& mark) const {
  const std::size_t after = nodes_until(mark.time());
  const std::size_t node = after == 0 ? 0 : after - 1;
  return {node, way_between(nodes_[node], mark.point_)};
}

void MapPath::keep_only(const std::vector<bool>& nodes) {
  std::size_t left = 0;
  bool gap = false;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    gap = gap || nodes_[i].after_gap;
    if (!nodes[i]) {
      gap = true;
      continue;
    }
    nodes_[left] = nodes_[i];
    nodes_[left++].after_gap = gap;
    gap = false;
  }
  nodes_.resize(left);
}

// Number of nodes at that time or before it.
std::size_t MapPath::nodes_until(TimeNs time) const {
  return static_cast<std::size_t>(first_after(nodes_, time) - nodes_.begin());
}

bool MapPath::is_forgotten(TimeNs time) const {
  const std::size_t after = nodes_until(time);
  return after < nodes_.size() && nodes_[after].after_gap;
}

// The place lies on an arc with the curvature between the node and its neighbour.
MapPath::Place MapPath::place(TimeNs time, double distance_m) const {
  const std::size_t after = nodes_until(time);
  const auto apart = [&](std::size_t i) {
    return is_forgotten(time) ? std::abs(to_seconds(nodes_[i].time - time))
                              : std::abs(nodes_[i].distance_m - distance_m);
  };
  Place place;
  place.node = after == 0 ? 0 : after - 1;
  if (after < nodes_.size() && apart(after) < apart(place.node)) place.node = after;
  const Point& node = nodes_[place.node];
  const bool has_next = place.node + 1 < nodes_.size() && !nodes_[place.node + 1].after_gap;
  const bool has_last = place.node > 0 && !node.after_gap;
  double curvature = 0.0;
  if (has_next || has_last) {
    const bool forwards = has_next && (place.node < after || !has_last);
    const std::size_t other = forwards ? place.node + 1 : place.node - 1;
    const PlanarPose step = way_between(node, nodes_[other]);
    if (std::abs(step.p.x()) > 0.3 * node_spacing_m_) curvature = step.yaw / step.p.x();
    const double ahead = nodes_[other].distance_m - node.distance_m;
    place.direction = (ahead < 0.0) == (other > place.node) ? -1 : 1;
  }
  const double along = distance_m - node.distance_m;
  place.at = along_arc(along, curvature);
  place.way = {place.at.p, along * place.direction < 0.0};
  return place;
}

MapPath::Place MapPath::place(TimeNs time) const {
  const bool between = time >= nodes_.front().time && time < nodes_.back().time;
  return place(time, between ? interpolated(nodes_, time, &Point::distance_m) : distance_at(time));
}

}  // namespace gprodom
