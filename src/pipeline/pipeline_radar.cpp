// What the pipeline does with the traces of its antennas, and with the passages of two in a row.
#include <cmath>
#include <utility>

#include "estimation/kernels/so3.h"
#include "gpr/pair/antenna_row.h"
#include "pipeline/pipeline.h"

namespace gprodom {

namespace {

// Traces kept while there are no ticks: before the first IMU sample, or without an IMU.
constexpr std::size_t kMostTraces = 2000;

// How long ago the front antenna may have passed the ground that is now under the rear one.
constexpr TimeNs kTravelKept = 60'000'000'000;  // ns

}  // namespace

// The map has the ground of one antenna: the first one, or the one followed in its place. Others
// that are abreast of it only look for that ground. Antennas differ by gain, time zero and pulse,
// so the map gets all traces as the first one would have measured them.
void Pipeline::store_trace(GprTrace trace) {
  if (!config_.gpr.enabled) return;
  const bool followed = trace.antenna_id == input_.followed();
  const bool in_place = input_.followed() != input_.antenna();
  if (config_.gpr.antennas.size() > 1 && !in_place) antenna_filter_.learn(trace);
  const bool is_mapped = map_->enabled() && !map_waits_;
  const auto as_of_first = [&] { return antenna_filter_.as_of(*input_.antenna(), trace); };
  if (followed && is_mapped) add_to_map(in_place ? as_of_first() : trace);
  const auto first = place_of(*input_.antenna()), own = place_of(trace.antenna_id);
  if (!followed && !in_place && is_mapped && first && own && gpr::are_abreast(*first, *own))
    map_->add_beside(as_of_first());
  if ((followed ? radar_.enabled() : radar_.has_pair()) && traces_.size() < kMostTraces)
    traces_.push_back(std::move(trace));
}

// What several traces agree in is the radar's setting. One of them alone may be damaged, and must
// not decide which ground is stored.
void Pipeline::add_to_map(const GprTrace& trace) {
  unagreed_.push_back(trace);
  const auto format = input_.trace_format();
  if (!format) return;
  if (ground_format_ && !same_format(*ground_format_, *format)) {
    std::optional<GroundMap> ground = ground_of_ ? ground_of_(*format) : std::nullopt;
    set_ground(ground ? std::move(*ground) : GroundMap(memory_options(config_)));
  }
  ground_format_ = format;
  for (const GprTrace& waiting : std::exchange(unagreed_, {}))
    if (same_format(*format, format_of(waiting))) map_->add(waiting);
}

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
  AntennaPassage weighed = passage;
  weighed.sigma_m *= std::sqrt(passage.overlap);
  motion_.add_passage(weighed);
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
  travel_.revise(result.way);
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
