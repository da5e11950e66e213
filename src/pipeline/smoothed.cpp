// All states of a run at once, after it: what smooths better than any window.
#include <algorithm>
#include <memory>
#include <stdexcept>

#include "pipeline/pipeline.h"

namespace gprodom {

const Batch& Pipeline::batch() const {
  if (!estimator_ || !estimator_->recorded())
    throw std::runtime_error("nothing recorded: call record() first, and let the robot start");
  return *estimator_->recorded();
}

// The batch with the revisits that the map rests on.
std::vector<NavState> Pipeline::smoothed() const {
  Batch batch = this->batch();
  const std::vector<NavState>& states = batch.states();
  const auto state_at = [&](TimeNs time) {
    const auto found = std::partition_point(states.begin(), states.end(),
                                            [time](const NavState& x) { return x.time < time; });
    return static_cast<size_t>(found - states.begin());
  };
  for (const Revisit& revisit : map_->revisits()) {
    const size_t memory = state_at(revisit.memory), query = state_at(revisit.query);
    if (memory < query && query < states.size())
      batch.add_factor(memory, query, std::make_shared<RevisitFactor>(revisit.edge));
  }
  // In map, which is not odom's frame where the track lies on ground from before.
  const PlanarPose map_from_odom = map_->map_from_odom();
  const Eigen::Quaterniond q(Eigen::AngleAxisd(map_from_odom.yaw, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d p(map_from_odom.p.x(), map_from_odom.p.y(), 0.0);
  std::vector<NavState> solved = batch.solve({});
  for (NavState& x : solved) {
    x.p_odom = q * x.p_odom + p;
    x.q_odom_body = q * x.q_odom_body;
  }
  return solved;
}

}  // namespace gprodom
