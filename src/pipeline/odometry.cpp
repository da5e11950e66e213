#include "gprodom/odometry.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "gprodom/error.h"
#include "map/ground_map_file.h"
#include "map/map_frame.h"
#include "map/search_window.h"
#include "persist/state_store.h"
#include "pipeline/pipeline.h"
#include "pipeline/rescue.h"

namespace gprodom {

namespace {

constexpr std::size_t kFaster = 10;  // messages, in advance_rerun(), for each new one

constexpr std::uint64_t kOfNoFile = ~std::uint64_t{0};  // as GroundMap::taken_from()

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
      map_frame_(std::make_unique<MapFrame>()),
      rescue_(std::make_unique<Rescue>()) {
  StartingPoint start;
  start.ground = store_->ground(memory_options(config), notices_);
  start.state = store_->state(notices_);
  start.pair = store_->pair(notices_);
  start.slip = store_->slip(notices_);
  start.mounting = store_->mounting(notices_);
  // A state is of axes that have to be known.
  if (!config.imu.rpy_body_imu.rpy && !start.mounting) start.state.reset();
  if (start.state && start.ground && !start.ground->goes_on_from(start.state->ground)) {
    start.state->correction.reset();
    start.state->map = -1;
  }
  restart(std::move(start));
}
Odometry::~Odometry() = default;

void Odometry::add(const ImuSample& sample) { pipeline_->add(sample); }
void Odometry::add(const WheelSample& sample) { pipeline_->add(sample); }
void Odometry::add(const WheelsSample& sample) { pipeline_->add(sample); }
void Odometry::add(const GprTrace& trace) { pipeline_->add(trace); }
void Odometry::add(const Displacement& external) { pipeline_->add(external); }
void Odometry::add(const PositionFix& fix) { pipeline_->add(fix); }
std::string Odometry::add_factor(const UserFactor& factor) { return pipeline_->add_factor(factor); }
void Odometry::reject(const std::string& channel, const std::string& reason) {
  pipeline_->reject(channel, reason);
}

void Odometry::start_jobs() { pipeline_->start_jobs(); }

Outputs Odometry::step() {
  const std::size_t before = pipeline_->buffer().size();
  Outputs out = pipeline_->step();
  const std::size_t after = pipeline_->buffer().size();  // less than before at a standstill
  if (pipeline_->buffers()) advance_rerun(kFaster * (after - std::min(after, before)));
  if (std::exchange(map_exchanged_, false)) map_frame_->reset();
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
  if (rerun_) advance_rerun(pipeline_->buffer().size());
  Outputs out = pipeline_->finish();
  out.odometry_in_map = map_frame_->place(out);
  if (store_->enabled()) {
    if (!out.odometry.empty()) newest_ = out.odometry.back();
    save_state();
    if (store_->writes_ground() && store_->is_locked()) begin_saving(store_->ground_path(), false);
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
    const bool newest = store_->newest_is_due(newest_.time);
    if (store_->ground_is_due(newest_.time))
      begin_saving(store_->ground_path(), false);
    else if (newest)
      begin_saving_newest();
  }
  // Else the disk's speed would decide which STATUS tells of a file.
  if (execution_ == Execution::kInline) store_->writer().flush();
  take_notices();
  pipeline_->report_files(store_->trouble(), store_->kept_aside(), store_->other_format());
  out.warnings.insert(out.warnings.begin(), std::make_move_iterator(notices_.begin()),
                      std::make_move_iterator(notices_.end()));
  notices_.clear();
}

void Odometry::save_state() {
  auto state = pipeline_->state(map_frame_->now());
  if (state && !store_->uses_main_ground()) state->ground = kOfNoFile;  // the next run begins there
  store_->save(newest_, state);
  const StartingPoint learnt = pipeline_->learnt();
  if (learnt.pair) store_->save(*learnt.pair);
  if (learnt.slip) store_->save(*learnt.slip);
  if (learnt.mounting) store_->save(*learnt.mounting);
}

void Odometry::begin_saving(const std::string& path, bool asked) {
  MapTask& map = ground_owner().map();
  if (!map.enabled()) return;
  map.save_ground(ground_owner().now(), path == store_->ground_path(),
                  [store = store_.get(), path, asked](SavedGround ground) {
                    store->save_ground(path, std::move(ground), asked);
                  });
}

void Odometry::begin_saving_newest() {
  MapTask& map = ground_owner().map();
  if (!map.enabled()) return;
  map.save_newest(ground_owner().now(),
                  [store = store_.get(), path = store_->ground_path()](SavedGround ground) {
                    store->save_ground(path, std::move(ground), false);
                  });
}

// Before the ground driven over is exchanged for another. Waits for the disk. False if it cannot be
// written.
bool Odometry::save_ground() {
  if (store_->enabled() && store_->writes_ground() && store_->is_locked())
    begin_saving(store_->ground_path(), false);
  pipeline_->drain();
  store_->writer().flush();
  take_notices();
  return !store_->failed(store_->ground_path());
}

void Odometry::take_notices() {
  for (std::string& notice : store_->take_notices()) notices_.push_back(std::move(notice));
}

void Odometry::begin_saving_map(const std::string& path) {
  expect_map(path);
  expect_writable(path);
  store_->await(path);
  begin_saving(path, true);
}

void Odometry::save_map(const std::string& path) {
  expect_map(path);
  expect_writable(path);
  const SavedGround ground = ground_owner().map().saved_ground();
  store_->writer().flush();
  std::vector<std::string> told;
  const bool replaced = store_->ground_files().replace(path, ground, told);
  store_->tell(told, notices_);
  if (!replaced)
    throw FileError(path + ": not saved: no ground is stored yet, and the file holds some");
}

void Odometry::load_map(const std::string& path) {
  expect_map(path);
  // The file may be one that is just being saved.
  pipeline_->drain();
  store_->writer().flush();
  auto ground = read_ground_map(path, memory_options(config_), notices_);
  if (!ground) throw FileError(path + ": no such file");
  const auto radar = pipeline_->trace_format();
  if (radar && ground->known_format() && !same_format(ground->format, *radar))
    throw FileError(path + ": not loaded: its ground is of " + text_of(ground->format) +
                    ", the radar sends " + text_of(*radar));
  if (!save_ground())
    throw FileError(path + ": not loaded: the ground driven over so far cannot be saved");
  store_->use_main_ground();
  ground_owner().set_ground(std::move(*ground));
  map_frame_->reset();
}

// The ground of the radar's new setting. That of the one before stays under its name, or, where it
// cannot be saved, in memory.
std::optional<GroundMap> Odometry::ground_of(const TraceFormat& format) {
  std::vector<GroundMap>& unsaved = rescue_->unsaved;
  const bool saved = save_ground() && store_->enabled() && store_->writes_ground();
  if (!saved) unsaved.push_back(ground_owner().map().take_ground());
  map_exchanged_ = true;
  if (store_->enabled()) store_->use_ground_of(format);
  const auto kept = std::find_if(unsaved.begin(), unsaved.end(), [&](const GroundMap& ground) {
    return same_format(ground.format, format);
  });
  std::optional<GroundMap> ground;
  if (kept != unsaved.end()) {
    ground = std::move(*kept);
    unsaved.erase(kept);
  } else {
    ground = store_->ground(memory_options(config_), notices_);
  }
  const bool usable = ground && ground->known_format() && same_format(ground->format, format);
  return usable ? std::move(ground) : std::nullopt;
}

void Odometry::locate_at(const RoughPlace& place) {
  expect_map("the place told");
  if (!std::isfinite(place.x) || !std::isfinite(place.y) || !std::isfinite(place.yaw))
    throw std::invalid_argument("expected finite figures");
  if (!(place.sigma_m > 0.0 && place.sigma_m <= kLostSigma))
    throw std::invalid_argument(
        "expected a sigma above 0 and up to 1.6 m: where less is known, the robot searches all "
        "ground by itself");
  const Eigen::Vector3d ahead = here_.q_odom_body * Eigen::Vector3d::UnitX();
  const PlanarPose in_odom{here_.p_odom_body.head<2>(), std::atan2(ahead.y(), ahead.x())};
  pipeline_->locate_at({place, in_odom});
}

// Throws an error about the file unless there is a map.
void Odometry::expect_map(const std::string& path) const {
  if (!ground_owner().map().enabled())
    throw FileError(path + ": there is no map: gpr.enabled or graph.enabled is false");
}

void Odometry::expect_writable(const std::string& path) const {
  if (!store_->writes_ground())
    throw FileError(path + ": state.map is read_only: no ground is written");
}

void Odometry::record() {
  records_ = true;
  pipeline_->record();
}

std::vector<OdometryEstimate> Odometry::recorded() const {
  return poses(pipeline_->batch().states(), *pipeline_);
}

std::vector<OdometryEstimate> Odometry::smoothed(std::map<int, FixAntenna>* antennas) const {
  return poses(pipeline_->smoothed(antennas), *pipeline_);
}

Timing Odometry::timing() const { return pipeline_->timing(); }

void Odometry::reset() {
  StartingPoint start = pipeline_->learnt();
  start.ground = ground_owner().map().take_ground();
  restart(std::move(start));
}

void Odometry::forget() {
  save_ground();
  set_ground_aside();
  store_->use_main_ground();
  restart({});
}

// The next run does not find it either.
void Odometry::set_ground_aside() {
  if (!store_->enabled() || !store_->writes_ground()) return;
  store_->writer().flush();
  std::vector<std::string> told;
  try {
    store_->ground_files().set_aside(store_->ground_path(), told);
  } catch (const FileError& error) {
    told.emplace_back(error.what());
  }
  store_->tell(told, notices_);
}

void Odometry::restart(StartingPoint start) { set_pipeline(make_pipeline(std::move(start))); }

Pipeline& Odometry::ground_owner() const { return rerun_ ? *rerun_ : *pipeline_; }

std::unique_ptr<Pipeline> Odometry::make_pipeline(StartingPoint start) {
  start.ground_of = [this](const TraceFormat& format) { return ground_of(format); };
  return std::make_unique<Pipeline>(config_, execution_, front_end_, std::move(start));
}

void Odometry::set_pipeline(std::unique_ptr<Pipeline> pipeline) {
  rerun_.reset();
  pipeline_ = std::move(pipeline);
  map_frame_->reset();
  here_ = {};
}

}  // namespace gprodom
