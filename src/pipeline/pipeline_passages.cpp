// Two antennas in a row: what the pipeline gives to their front end, and takes from it.
#include <cmath>
#include <utility>

#include "estimation/kernels/so3.h"
#include "pipeline/pipeline.h"

namespace gprodom {

namespace {

// How long ago the front antenna may have passed the ground that is now under the rear one.
constexpr TimeNs kTravelKept = 60'000'000'000;  // ns

}  // namespace

void Pipeline::take_passage(const gpr::Passage& passage, TimeNs effective) {
  Displacement d;
  d.time = effective;
  d.from = passage.from;
  d.to = passage.to;
  d.source = "pair";
  d.kind = DisplacementKind::kSequential;
  d.valid = true;
  d.distance_m = passage.distance_m();
  d.sigma_m = passage.sigma_m;
  d.score = passage.score;
  motion_.add_passage({passage.from, passage.to, passage.lever_from, passage.lever_to,
                       passage.sigma_m * std::sqrt(passage.overlap)});
  slip_drift_.measured_since(passage.from, passage.sigma_m / std::abs(d.distance_m));
  health_.add("pair.passages", 1);
  out_.displacements.push_back(stamped(std::move(d)));
}

// In body; nothing for one that is not in gpr.antennas, and so is the only one.
std::optional<Eigen::Vector3d> Pipeline::place_of(int antenna) const {
  const auto place = config_.gpr.antennas.find(antenna);
  if (place == config_.gpr.antennas.end()) return std::nullopt;
  return place->second;
}

// Where the robot drives and the pair finds nothing, the estimate goes on as with one antenna.
void Pipeline::report_antennas(gpr::PairState state) {
  health_.set("antennas", HealthLevel::kDegraded,
              state == gpr::PairState::kNoMatch
                  ? "the rear antenna does not see what the front one saw: compare gpr.antennas "
                    "with the mounting"
              : state == gpr::PairState::kSwapped
                  ? "swapped: the antenna that gpr.antennas has in the rear sees the ground first; "
                    "exchange the cables, or the ids"
                  : "");
  health_.await("pair", HealthLevel::kOk,
                state == gpr::PairState::kLearns      ? "learns how the antennas differ"
                : state == gpr::PairState::kAmbiguous ? "the ground repeats itself: not used here"
                                                      : "");
}

void Pipeline::keep_way(const StateResult& result) {
  if (result.way.empty()) return;
  std::vector<gpr::Travel::Point> way;
  for (const WayPoint& point : result.way)
    way.push_back({point.time, point.s_m, point.heading_rad});
  travel_.revise(way);
  travel_.forget_before(result.state.time - kTravelKept);
}

// The path up to now: of the window's states, and as predicted since the newest of them.
gpr::Travel Pipeline::travel() const {
  gpr::Travel travel = travel_;
  if (travel.empty()) return travel;
  const StateResult& base = prediction_.base();
  const Eigen::Vector3d x_axis = base.state.q_odom_body * Eigen::Vector3d::UnitX();
  const Eigen::Matrix3d v_covariance = base.covariance.block<3, 3>(row::kV, row::kV);
  travel.set_speed(x_axis.dot(base.state.v_odom), std::sqrt(x_axis.dot(v_covariance * x_axis)),
                   config_.wheel.enabled && !base.no_wheel);
  if (prediction_.time() <= travel.points().back().time) return travel;
  const NavState now = prediction_.state();
  const double ahead = x_axis.dot(now.p_odom - base.state.p_odom);
  const Eigen::Vector3d turned = so3::log(base.state.q_odom_body.conjugate() * now.q_odom_body);
  const gpr::Travel::Point& newest = travel.points().back();
  travel.append({prediction_.time(), newest.s_m + ahead, newest.heading_rad + turned.z()});
  return travel;
}

}  // namespace gprodom
