// All states of a run at once, after it: what smooths better than any window.
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "pipeline/pipeline.h"

namespace gprodom {
namespace {

// A state of odom where the map has it: its piece of the track turned, shifted and stretched.
NavState warped(const NavState& state, const TrackPiece& piece, const PlanarPose& odom_from_map) {
  const PlanarPose begins = compose(odom_from_map, piece.in_map);
  const double turn = begins.yaw - piece.in_odom.yaw, stretch = std::exp(piece.slip);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d from(piece.in_odom.p.x(), piece.in_odom.p.y(), state.p_odom.z());
  NavState result = state;
  result.p_odom = q * (stretch * (state.p_odom - from));
  result.p_odom += Eigen::Vector3d(begins.p.x(), begins.p.y(), state.p_odom.z());
  result.q_odom_body = (q * state.q_odom_body).normalized();
  result.v_odom = q * (stretch * state.v_odom);
  return result;
}

// The wheel slipped as the map has found, and the solution begins where the map lies: from afar
// the robust kernels of the revisits would not let it get there.
void begin_as_map(const std::vector<TrackPiece>& track, const PlanarPose& map_from_odom,
                  Batch& batch) {
  const PlanarPose odom_from_map = between(map_from_odom, {});
  std::size_t piece = 0;
  for (std::size_t i = 0; i < batch.size() && !track.empty(); ++i) {
    const NavState state = batch.states()[i];
    while (piece + 1 < track.size() && track[piece + 1].from <= state.time) ++piece;
    if (state.time < track[piece].from) continue;
    batch.set_slip(i, track[piece].slip);
    batch.set_state(i, warped(state, track[piece], odom_from_map));
  }
}

}  // namespace

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
  begin_as_map(map_->track(), map_from_odom, batch);
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
