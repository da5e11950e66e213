#include "map/pass_finder.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace gprodom {
namespace {

constexpr double kHeadingGate = 0.5;  // rad between the tracks then and now

bool parallel(double turned) {
  return std::abs(std::remainder(turned, M_PI)) < kHeadingGate;  // either way
}

}  // namespace

PassFinder::PassFinder(const PlanarPose& here, double along_m, double aside_m, double arm_m)
    : here_(here), along_m_(along_m), aside_m_(aside_m) {
  const double farthest = along_m + aside_m + arm_m;
  farthest_m2_ = farthest * farthest;
}

bool PassFinder::may_be_near(const PlanarPose& body) {
  if ((body.p - here_.p).squaredNorm() <= farthest_m2_) return true;
  on_pass_ = false;
  return false;
}

void PassFinder::offer(std::size_t place, const PlanarPose& antenna, bool from_before) {
  const bool was_on_pass = on_pass_;
  on_pass_ = false;
  const PlanarPose relative = between(antenna, here_);
  if (!parallel(relative.yaw) || std::abs(relative.p.y()) >= aside_m_ ||
      std::abs(relative.p.x()) >= along_m_) {
    return;
  }
  on_pass_ = true;
  const Pass pass{place, from_before, relative.p.x(), relative.p.y(), std::cos(relative.yaw) < 0.0};
  if (!was_on_pass) passes_.push_back(pass);
  if (std::abs(pass.along) < std::abs(passes_.back().along)) passes_.back() = pass;
}

std::vector<Pass> in_search_order(std::vector<Pass> passes, double alike_m) {
  if (passes.size() < 2) return passes;
  const auto newest = std::find_if(passes.rbegin(), passes.rend(),
                                   [&](const Pass& p) { return std::abs(p.lateral) < alike_m; });
  const std::optional<Pass> like_it =
      newest == passes.rend() ? std::nullopt : std::optional<Pass>(*newest);
  std::stable_sort(passes.begin(), passes.end(), [](const Pass& a, const Pass& b) {
    return std::abs(a.lateral) < std::abs(b.lateral);
  });
  if (!like_it) return passes;
  const auto at = std::find_if(passes.begin() + 1, passes.end(), [&](const Pass& p) {
    return p.place == like_it->place && p.from_before == like_it->from_before;
  });
  if (at != passes.end()) std::rotate(passes.begin() + 1, at, at + 1);
  return passes;
}

}  // namespace gprodom
