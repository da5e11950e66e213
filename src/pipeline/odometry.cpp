#include "gprodom/odometry.h"

#include "pipeline/map_frame.h"
#include "pipeline/pipeline.h"

namespace gprodom {

namespace {

std::vector<OdometryEstimate> poses(const std::vector<NavState>& states) {
  std::vector<OdometryEstimate> estimates(states.size());
  for (size_t i = 0; i < states.size(); ++i) {
    estimates[i].time = states[i].time;
    estimates[i].p_odom_body = states[i].p_odom;
    estimates[i].q_odom_body = states[i].q_odom_body;
  }
  return estimates;
}

}  // namespace

Odometry::Odometry(const Config& config, Execution execution)
    : config_(config),
      execution_(execution),
      pipeline_(std::make_unique<Pipeline>(config, execution)),
      map_frame_(std::make_unique<MapFrame>()) {}
Odometry::~Odometry() = default;

void Odometry::add(const ImuSample& sample) { pipeline_->add(sample); }
void Odometry::add(const WheelSample& sample) { pipeline_->add(sample); }
void Odometry::add(const GprTrace& trace) { pipeline_->add(trace); }
void Odometry::add(const Displacement& external) { pipeline_->add(external); }
void Odometry::reject(const std::string& channel, const std::string& reason) {
  pipeline_->reject(channel, reason);
}

Outputs Odometry::step() {
  Outputs out = pipeline_->step();
  out.odometry_in_map = map_frame_->place(out);
  if (pipeline_->must_restart()) {
    auto inbox = pipeline_->take_inbox();
    reset();
    for (auto& message : inbox) pipeline_->add(std::move(message));
    out.warnings.push_back("the IMU's clock was set: starting afresh");
    out.restarted = true;
  }
  return out;
}

Outputs Odometry::finish() {
  Outputs out = pipeline_->finish();
  out.odometry_in_map = map_frame_->place(out);
  return out;
}

void Odometry::record() { pipeline_->record(); }

std::vector<OdometryEstimate> Odometry::recorded() const {
  return poses(pipeline_->batch().states());
}

std::vector<OdometryEstimate> Odometry::smoothed() const { return poses(pipeline_->smoothed()); }

Timing Odometry::timing() const { return pipeline_->timing(); }

void Odometry::reset() {
  pipeline_ = std::make_unique<Pipeline>(config_, execution_);
  map_frame_->reset();
}

}  // namespace gprodom
