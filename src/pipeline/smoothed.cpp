// The batch solution: all states of a run at once, after its end.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pipeline/pipeline.h"

namespace gprodom {
namespace {

// 1/sqrt(s), 0.3 % in 100 s: the ground under a wheel changes. Only where there are fixes, which
// measure it. With three times as much, accelerations move the scale between them.
constexpr double kScaleWalk = 3e-4;
// A smaller slip of the graph, where there are fixes: the ground under the wheel, for which the
// scale walks here, and errors of the fixes, which would count twice.
constexpr double kLeastSlip = 2 * SlipModel().surface;

// A state of odom moved to where the map has it: rotated, shifted and stretched with its piece of
// the track.
NavState warped(const NavState& state, const TrackPiece& piece, const PlanarPose& odom_from_map) {
  const PlanarPose begins = compose(odom_from_map, piece.in_map);
  const double turn = begins.yaw - piece.in_odom.yaw, stretch = std::exp(piece.slip.value_or(0.0));
  const Eigen::Quaterniond q(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d from(piece.in_odom.p.x(), piece.in_odom.p.y(), state.p_odom.z());
  NavState result = state;
  result.p_odom = q * (stretch * (state.p_odom - from));
  result.p_odom += Eigen::Vector3d(begins.p.x(), begins.p.y(), state.p_odom.z());
  result.q_odom_body = (q * state.q_odom_body).normalized();
  result.v_odom = q * (stretch * state.v_odom);
  return result;
}

// Takes over the slip that the pose graph has found, and starts the solution at the map's poses.
// From further away the robust kernels of the revisits would keep it from converging to them.
void start_at_map(const std::vector<TrackPiece>& track, const PlanarPose& map_from_odom,
                  double least_slip, Batch& batch) {
  const PlanarPose odom_from_map = between(map_from_odom, {});
  std::size_t piece = 0;
  std::vector<std::optional<double>> slips(batch.size());
  for (std::size_t i = 0; i < batch.size() && !track.empty(); ++i) {
    const NavState state = batch.states()[i];
    while (piece + 1 < track.size() && track[piece + 1].from <= state.time) ++piece;
    if (state.time < track[piece].from) continue;
    const std::optional<double> slip = track[piece].slip;
    if (slip && std::abs(*slip) >= least_slip) slips[i] = slip;
    batch.set_state(i, warped(state, track[piece], odom_from_map));
  }
  batch.set_slips(slips);
}

// An antenna of fixes: its number in the batch, and where it was told to be.
struct ToldAntenna {
  std::size_t number;
  Eigen::Vector3d place;
};

std::map<int, ToldAntenna> add_antennas(const std::vector<UsedFix>& fixes, Batch& batch) {
  std::map<int, ToldAntenna> told;
  std::vector<Batch::Antenna> antennas;
  for (const UsedFix& fix : fixes) {
    const ToldAntenna antenna{antennas.size(), fix.lever_arm};
    if (told.emplace(fix.antenna, antenna).second) antennas.push_back({fix.arm_sigma, kDelaySigma});
  }
  batch.set_antennas(std::move(antennas));
  return told;
}

// Fixes are in map. They measure the place of the first state, which nothing else does.
void add_fixes(const std::vector<UsedFix>& fixes, const std::map<int, ToldAntenna>& told,
               const PlanarPose& map_from_odom, Batch& batch) {
  const std::vector<NavState>& states = batch.states();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-map_from_odom.yaw).toRotationMatrix();
  std::vector<std::optional<std::size_t>> numbers;  // in the batch
  for (const UsedFix& fix : fixes) {
    numbers.emplace_back();
    const auto next = std::partition_point(states.begin(), states.end(),
                                           [&](const NavState& x) { return x.time <= fix.time; });
    if (next == states.begin() || next == states.end()) continue;
    const NavState& a = *(next - 1);
    const double seconds = to_seconds(next->time - a.time);
    const double share = to_seconds(fix.time - a.time) / seconds;
    const auto i = static_cast<size_t>(next - states.begin());
    const FixEdge& edge = fix.edge;
    const FixFactor place(turn * (edge.p - map_from_odom.p),
                          turn * edge.covariance * turn.transpose(), fix.lever_arm, share, seconds);
    const auto before = edge.before ? numbers[*edge.before] : std::nullopt;
    numbers.back() = batch.add_fix(
        {i - 1, i, place, edge.white, before, edge.kept, told.at(fix.antenna).number});
  }
  if (fixes.empty()) return;
  batch.free_place();
  batch.set_scale_walk(kScaleWalk);
}

}  // namespace

const Batch& Pipeline::batch() const {
  if (!estimator_ || !estimator_->recorded())
    throw std::runtime_error("nothing recorded: call record() first, and let the robot start");
  return *estimator_->recorded();
}

// Solves the batch together with the trusted revisits.
std::vector<NavState> Pipeline::smoothed(std::map<int, FixAntenna>* antennas) const {
  Batch batch = this->batch();
  const std::vector<NavState>& states = batch.states();
  const auto state_at = [&](TimeNs time) {
    const auto found = std::partition_point(states.begin(), states.end(),
                                            [time](const NavState& x) { return x.time < time; });
    return static_cast<size_t>(found - states.begin());
  };
  const std::vector<Revisit> revisits = map_->revisits();
  const std::vector<UsedFix> fixes = map_->used_fixes();
  if (!revisits.empty() || !fixes.empty()) batch.free_scale();
  for (const Revisit& revisit : revisits) {
    const size_t memory = state_at(revisit.memory), query = state_at(revisit.query);
    if (memory < query && query < states.size())
      batch.add_factor(memory, query, std::make_shared<RevisitFactor>(revisit.edge));
  }
  // The result is in map, which differs from odom if the track is tied to an earlier map.
  const PlanarPose map_from_odom = map_->map_from_odom();
  const std::map<int, ToldAntenna> told = add_antennas(fixes, batch);
  add_fixes(fixes, told, map_from_odom, batch);
  start_at_map(map_->track(), map_from_odom, fixes.empty() ? 0.0 : kLeastSlip, batch);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(map_from_odom.yaw, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d p(map_from_odom.p.x(), map_from_odom.p.y(), 0.0);
  std::vector<Eigen::Vector3d> found;
  std::vector<NavState> solved = batch.solve({}, &found);
  for (const auto& [id, antenna] : told) {
    const Eigen::Vector3d& by = found[antenna.number];
    if (antennas) (*antennas)[id] = {antenna.place + Eigen::Vector3d(by.x(), by.y(), 0.0), by.z()};
  }
  for (NavState& x : solved) {
    x.p_odom = q * x.p_odom + p;
    x.q_odom_body = q * x.q_odom_body;
  }
  return solved;
}

}  // namespace gprodom
