// How the estimator goes on after an exception inside it.
#include <exception>
#include <utility>

#include "gprodom/odometry.h"
#include "map/ground_map_file.h"
#include "map/map_frame.h"
#include "persist/state_store.h"
#include "pipeline/pipeline.h"
#include "pipeline/rescue.h"

namespace gprodom {
namespace {

// The map may throw so often within that time before its ground is left out. Once is chance; a
// front end or a sensor that throws is no fault of the ground and is not counted.
constexpr std::size_t kMostMapFailures = 3;
constexpr TimeNs kMapFailuresWithin = 60'000'000'000;

bool is_of_map(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const MapFailure&) {
    return true;
  } catch (...) {
    return false;
  }
}

// A wheel scale that is known better than the configured one becomes the prior.
void take_scale(const OdometryEstimate& newest, WheelConfig& wheel) {
  const double sigma = newest.wheel_scale_sigma;
  if (!(sigma > 0.0 && sigma < wheel.scale_sigma)) return;
  wheel.scale = newest.wheel_scale;
  wheel.scale_sigma = sigma;
}

}  // namespace

void Odometry::recover(const std::exception_ptr& failure) {
  if (!std::exchange(rescue_->begun, true)) {
    const bool of_map = is_of_map(failure);
    auto& failures = rescue_->map_failures;
    if (of_map) failures.push_back(pipeline_->now());
    while (!failures.empty() && failures.front() + kMapFailuresWithin < pipeline_->now())
      failures.pop_front();
    rescue_->ground = rescued_ground(of_map);
    if (failures.size() >= kMostMapFailures) {
      failures.clear();
      rescue_->ground.reset();
      set_ground_aside();
      notices_.emplace_back("the map has failed three times in a minute: its ground is left out");
    }
  }
  take_scale(newest_, config_.wheel);
  // Without the ground, which would be lost if this throws.
  restart(pipeline_->learnt());
  if (rescue_->ground) pipeline_->set_ground(std::move(*rescue_->ground));
  rescue_->ground.reset();
  rescue_->begun = false;
}

// The ground that the failed estimator has. After a failure of the map it must be whole, as a file
// that is read must be; otherwise that of the last saving counts.
std::optional<GroundMap> Odometry::rescued_ground(bool of_map) {
  if (!ground_owner().map().enabled()) return std::nullopt;
  try {
    GroundMap ground = ground_owner().map().take_ground();
    if (of_map) ground_map_from("ground", to_bytes(ground, ground.places), memory_options(config_));
    return ground;
  } catch (const std::exception& error) {
    notices_.push_back(std::string("the ground of the last saving is used: ") + error.what());
  }
  return store_->ground(memory_options(config_), notices_);
}

}  // namespace gprodom
