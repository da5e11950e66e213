#include "map/fixes/fix_keeper.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom {
namespace {

// An anchor is kept after so many metres, or so many seconds at one place.
constexpr double kEvery = kNodeSpacing, kEverySeconds = 10.0;
// Standard deviation of the antenna's place on the robot, m, if it was told and if it was not.
constexpr double kToldArm = 0.02, kUntoldArm = 0.5;
// A position to the last digit that came already, so many metres ago, is not measured anew.
constexpr double kRepeatedWithin = 0.5;
constexpr std::size_t kMostRepeated = 5000;  // positions remembered

}  // namespace

FixKeeper::FixKeeper(const AnchorConfig& config) : config_(config) {
  if (config.datum) datum_ = Datum(*config.datum);
}

void FixKeeper::suppose_origin(const Geodetic& origin) {
  if (!datum_) datum_ = Datum(origin);
}

FixTrouble FixKeeper::place(const PositionFix& fix, Eigen::Vector3d& in_site) {
  in_site = fix.position;
  if (fix.frame == FixFrame::kSite) return FixTrouble::kNone;
  if (!datum_) datum_ = Datum(fix.position);
  in_site = datum_->to_site(fix.position);
  if (in_site.norm() < kFarFromDatum) return FixTrouble::kNone;
  const Geodetic swapped(fix.position.y(), fix.position.x(), fix.position.z());
  const bool fits = std::abs(swapped.x()) <= 90 && datum_->to_site(swapped).norm() < kFarFromDatum;
  return fits ? FixTrouble::kSwapped : FixTrouble::kFar;
}

bool FixKeeper::repeats(const PositionFix& fix, const MapPath::Mark& mark) {
  const std::vector<double> key{static_cast<double>(fix.antenna_id), fix.position.x(),
                                fix.position.y(), fix.position.z()};
  const auto [found, is_new] = came_at_.emplace(key, mark.travelled());
  if (!is_new) return mark.travelled() - found->second > kRepeatedWithin;
  order_.push_back(key);
  if (order_.size() > kMostRepeated) {
    came_at_.erase(order_.front());
    order_.erase(order_.begin());
  }
  return false;
}

void FixKeeper::add(const PositionFix& fix, const MapPath::Mark& mark, const ScaleKnown& scale) {
  const auto newest = newest_.find(fix.antenna_id);
  if (repeats(fix, mark)) {
    trouble_ = FixTrouble::kRepeated;
    return;
  }
  if (newest != newest_.end()) {
    const double seconds = to_seconds(mark.time() - newest->second.time());
    if (seconds <= 0.0) return;
    if (mark.travelled() - newest->second.travelled() < kEvery && seconds < kEverySeconds) return;
  }
  Anchor anchor{mark,           fix.position, fix.covariance, Eigen::Vector3d::Zero(), kUntoldArm,
                fix.antenna_id, fix.quality,  std::nullopt,   fix.heading_sigma};
  trouble_ = place(fix, anchor.p);
  if (trouble_ != FixTrouble::kNone) return;
  const auto lever = config_.antennas.find(fix.antenna_id);
  if (lever != config_.antennas.end()) {
    anchor.lever_arm = lever->second;
    anchor.arm_sigma = kToldArm;
  }
  if (fix.has_heading) anchor.heading = fix.heading;
  newest_.insert_or_assign(fix.antenna_id, mark);
  judge_.add(anchor, scale);
  trouble_ = judge_.trouble();
  link();
}

void FixKeeper::link() {
  std::vector<Anchor> trusted = judge_.trusted();
  changed_ = changed_ || !std::equal(trusted.begin(), trusted.end(), anchors_.begin(),
                                     anchors_.end(), [](const Anchor& a, const Anchor& b) {
                                       return a.mark.time() == b.mark.time();
                                     });
  anchors_ = std::move(trusted);
  before_.clear();
  std::map<std::pair<int, FixQuality>, std::size_t> last;
  for (std::size_t i = 0; i < anchors_.size(); ++i) {
    const auto [found, is_first] =
        last.emplace(std::pair(anchors_[i].antenna, anchors_[i].quality), i);
    before_.push_back(is_first ? std::nullopt : std::optional(std::exchange(found->second, i)));
  }
}

std::optional<PlanarPose> fit_site(const std::vector<PlacePair>& pairs) {
  double sum = 0.0;
  Eigen::Vector2d track = Eigen::Vector2d::Zero(), site = Eigen::Vector2d::Zero();
  for (const PlacePair& pair : pairs) {
    const double weight = 1 / (pair.sigma_m * pair.sigma_m);
    sum += weight;
    track += weight * pair.in_track.p;
    site += weight * pair.in_site;
  }
  if (!(sum > 0.0)) return std::nullopt;
  track /= sum;
  site /= sum;
  // The heading by the places, and that by the fixes themselves, as sums of unit vectors.
  Eigen::Vector2d turn = Eigen::Vector2d::Zero();
  double information = 0.0;
  for (const PlacePair& pair : pairs) {
    const double weight = 1 / (pair.sigma_m * pair.sigma_m);
    const Eigen::Vector2d a = pair.in_track.p - track, b = pair.in_site - site;
    turn += weight * Eigen::Vector2d(a.dot(b), a.x() * b.y() - a.y() * b.x());
    information += weight * a.squaredNorm();
    if (!pair.heading) continue;
    const double told = 1 / (pair.heading_sigma * pair.heading_sigma);
    const double yaw = *pair.heading - pair.in_track.yaw;
    turn += told * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    information += told;
  }
  if (!(information > 0.0) || turn.isZero()) return std::nullopt;
  PlanarPose fit;
  fit.yaw = std::atan2(turn.y(), turn.x());
  fit.p = site - Eigen::Rotation2Dd(fit.yaw) * track;
  return fit;
}

}  // namespace gprodom
