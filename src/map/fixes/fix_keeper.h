// The fixes of a track: brought to `site`, thinned, judged, and weighted for what they have in
// common. docs/anchors.md.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/position_fix.h"
#include "map/fixes/anchor.h"
#include "map/fixes/datum.h"
#include "map/fixes/fix_judge.h"

namespace gprodom {

class FixKeeper {
 public:
  explicit FixKeeper(const AnchorConfig& config);

  // Of site, where neither the configuration nor a fix has told it: that of an earlier track.
  void suppose_origin(const Geodetic& origin);

  void add(const PositionFix& fix, const MapPath::Mark& mark, const ScaleKnown& scale);

  bool any() const { return !newest_.empty() || trouble_ != FixTrouble::kNone; }

  // Those that are trusted, in time order.
  const std::vector<Anchor>& anchors() const { return anchors_; }
  // The number of the anchor whose lasting error that of anchor i goes on from: the one before it
  // of the same antenna and quality.
  std::optional<std::size_t> before(std::size_t i) const { return before_[i]; }

  // Whether the trusted ones are others than at the last call.
  bool take_change() { return std::exchange(changed_, false); }

  const std::optional<Datum>& datum() const { return datum_; }
  std::size_t refused() const { return judge_.refused(); }
  FixTrouble trouble() const { return trouble_; }

 private:
  FixTrouble place(const PositionFix& fix, Eigen::Vector3d& in_site);
  bool repeats(const PositionFix& fix, const MapPath::Mark& mark);
  void link();

  const AnchorConfig config_;
  std::optional<Datum> datum_;
  FixJudge judge_;
  std::vector<Anchor> anchors_;
  std::vector<std::optional<std::size_t>> before_;
  std::map<int, MapPath::Mark> newest_;  // kept, by antenna
  // Metres driven at the positions as they came, by antenna; the newest ones.
  std::map<std::vector<double>, double> came_at_;
  std::vector<std::vector<double>> order_;
  bool changed_ = false;
  FixTrouble trouble_ = FixTrouble::kNone;
};

// One place: in the frame of the track, in site, its standard deviation in one direction, and the
// heading in site, if the fix has one.
struct PlacePair {
  PlanarPose in_track;
  Eigen::Vector2d in_site;
  double sigma_m = 1.0;
  std::optional<double> heading;
  double heading_sigma = 0.0;
};

// How the track's frame lies in site, by least squares. Nothing where the places do not tell the
// heading.
std::optional<PlanarPose> fit_site(const std::vector<PlacePair>& pairs);

}  // namespace gprodom
