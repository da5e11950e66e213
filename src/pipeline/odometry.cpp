#include "gprodom/odometry.h"

#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "base/atomic_file.h"
#include "gprodom/error.h"
#include "map/ground_map_file.h"
#include "map/map_frame.h"
#include "persist/state_store.h"
#include "pipeline/pipeline.h"

namespace gprodom {

namespace {

std::vector<OdometryEstimate> poses(const std::vector<NavState>& states, const Pipeline& pipeline) {
  std::vector<OdometryEstimate> estimates(states.size());
  for (size_t i = 0; i < states.size(); ++i) {
    estimates[i].time = pipeline.sensor_stamp(states[i].time);
    estimates[i].p_odom_body = states[i].p_odom;
    estimates[i].q_odom_body = states[i].q_odom_body;
  }
  return estimates;
}

}  // namespace

Odometry::Odometry(const Config& config, Execution execution, gpr::FrontEndFactory front_end)
    : store_(std::make_unique<StateStore>(config)),
      config_(store_->config_with_wheel_scale(notices_)),
      execution_(execution),
      front_end_(std::move(front_end)),
      pipeline_(std::make_unique<Pipeline>(
          config_, execution, front_end_,
          StartingPoint{store_->ground(memory_options(config), notices_), store_->state(notices_),
                        store_->pair(notices_), store_->slip(notices_)})),
      map_frame_(std::make_unique<MapFrame>()) {}
Odometry::~Odometry() = default;

void Odometry::add(const ImuSample& sample) { pipeline_->add(sample); }
void Odometry::add(const WheelSample& sample) { pipeline_->add(sample); }
void Odometry::add(const WheelsSample& sample) { pipeline_->add(sample); }
void Odometry::add(const GprTrace& trace) { pipeline_->add(trace); }
void Odometry::add(const Displacement& external) { pipeline_->add(external); }
std::string Odometry::add_factor(const UserFactor& factor) { return pipeline_->add_factor(factor); }
void Odometry::reject(const std::string& channel, const std::string& reason) {
  pipeline_->reject(channel, reason);
}

void Odometry::start_jobs() { pipeline_->start_jobs(); }

Outputs Odometry::step() {
  Outputs out = pipeline_->step();
  if (const auto correction = pipeline_->take_resumed_correction()) map_frame_->reset(correction);
  out.odometry_in_map = map_frame_->place(out);
  save_due(out);
  if (pipeline_->must_restart()) {
    auto inbox = pipeline_->take_inbox();
    reset();
    for (auto& message : inbox) pipeline_->add(std::move(message));
    pipeline_->reject(config_.channels.imu, "clock was set: the estimator restarts");
    out.warnings.push_back("the IMU's clock was set: the estimator restarts");
    out.restarted = true;
  }
  return out;
}

Outputs Odometry::finish() {
  Outputs out = pipeline_->finish();
  out.odometry_in_map = map_frame_->place(out);
  if (store_->enabled()) {
    if (!out.odometry.empty()) newest_ = out.odometry.back();
    save_state();
    if (store_->writes_ground()) begin_saving(store_->ground_path());
    pipeline_->drain();
  }
  store_->writer().flush();  // also what a command has asked for
  save_due(out);
  return out;
}

// Saves what is due, and reports the results of earlier savings.
void Odometry::save_due(Outputs& out) {
  if (!out.odometry.empty()) {
    here_ = newest_ = out.odometry.back();
    if (store_->state_is_due(newest_.time)) save_state();
    if (store_->ground_is_due(newest_.time)) begin_saving(store_->ground_path());
  }
  for (std::string& notice : store_->take_notices()) notices_.push_back(std::move(notice));
  pipeline_->report_files(store_->trouble());
  out.warnings.insert(out.warnings.begin(), std::make_move_iterator(notices_.begin()),
                      std::make_move_iterator(notices_.end()));
  notices_.clear();
}

void Odometry::save_state() {
  store_->save(newest_, pipeline_->state(map_frame_->now()));
  if (const auto pair = pipeline_->learnt_pair()) store_->save(*pair);
  store_->save(pipeline_->learnt_slip());
}

void Odometry::begin_saving(const std::string& path) {
  if (!pipeline_->has_map()) return;
  pipeline_->save_ground([store = store_.get(), path](std::string bytes) {
    store->writer().write(path, std::move(bytes));
  });
}

void Odometry::begin_saving_map(const std::string& path) {
  expect_map(path);
  expect_writable(path);
  store_->await(path);
  begin_saving(path);
}

void Odometry::save_map(const std::string& path) {
  expect_map(path);
  expect_writable(path);
  const std::string bytes = pipeline_->ground_bytes();
  store_->writer().flush();
  write_whole(path, bytes);
}

void Odometry::load_map(const std::string& path) {
  expect_map(path);
  // The file may be one that is just being saved.
  pipeline_->drain();
  store_->writer().flush();
  std::string bytes;
  if (!read_whole(path, bytes)) throw FileError(path + ": no such file");
  pipeline_->set_ground(ground_map_from(path, bytes, memory_options(config_)));
  map_frame_->reset();
}

void Odometry::locate_at(const RoughPlace& place) {
  expect_map("the place told");
  if (!std::isfinite(place.x) || !std::isfinite(place.y) || !std::isfinite(place.yaw))
    throw std::invalid_argument("expected finite figures");
  const double most_m = kGateMax / kGateSigmas;
  if (!(place.sigma_m > 0.0 && place.sigma_m <= most_m))
    throw std::invalid_argument(
        "expected a sigma above 0 and up to 1.6 m: where less is known, the robot searches all "
        "ground by itself");
  const Eigen::Vector3d ahead = here_.q_odom_body * Eigen::Vector3d::UnitX();
  const PlanarPose in_odom{here_.p_odom_body.head<2>(), std::atan2(ahead.y(), ahead.x())};
  pipeline_->locate_at({place, in_odom});
}

// Throws an error about the file unless there is a map.
void Odometry::expect_map(const std::string& path) const {
  if (!pipeline_->has_map())
    throw FileError(path + ": there is no map: gpr.enabled or graph.enabled is false");
}

void Odometry::expect_writable(const std::string& path) const {
  if (!store_->writes_ground())
    throw FileError(path + ": state.map is read_only: no ground is written");
}

void Odometry::record() { pipeline_->record(); }

std::vector<OdometryEstimate> Odometry::recorded() const {
  return poses(pipeline_->batch().states(), *pipeline_);
}

std::vector<OdometryEstimate> Odometry::smoothed() const {
  return poses(pipeline_->smoothed(), *pipeline_);
}

Timing Odometry::timing() const { return pipeline_->timing(); }

void Odometry::reset() {
  restart(
      {pipeline_->take_ground(), std::nullopt, pipeline_->learnt_pair(), pipeline_->learnt_slip()});
}

void Odometry::forget() { restart({}); }

void Odometry::restart(StartingPoint start) {
  pipeline_ = std::make_unique<Pipeline>(config_, execution_, front_end_, std::move(start));
  map_frame_->reset();
  here_ = {};
}

}  // namespace gprodom
