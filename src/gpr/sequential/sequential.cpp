#include "gpr/sequential/sequential.h"

#include <cmath>
#include <string>

#include "gprodom/error.h"

namespace gprodom::gpr {

SequentialFrontEnd::SequentialFrontEnd(const GprConfig& config)
    : config_(config), filter_(config.filter), matcher_(make_window_matcher(config)) {
  if (config.sequential.columns > config.sequential.window_traces) {
    throw ConfigError("paper.columns: expected at most paper.window_traces (" +
                      std::to_string(config.sequential.window_traces) + ")");
  }
}

SequentialFrontEnd::~SequentialFrontEnd() = default;

void SequentialFrontEnd::add_trace(const GprTrace& trace) {
  if (!first_trace_) first_trace_ = trace.time;
  if (last_trace_) trace_interval_s_ = to_seconds(trace.time - *last_trace_);
  last_trace_ = trace.time;

  WindowTrace in_window;
  in_window.time_s = to_seconds(trace.time - *first_trace_);
  in_window.count = trace.samples.size();
  in_window.sample_interval_s = trace.sample_interval_s;
  in_window.time_zero_s = trace.time_zero_s;
  in_window.filtered = filter_.filter(trace).samples;
  if (in_window.filtered != nullptr) in_window.raw = trace.samples.data();
  matcher_->add(in_window);
}

std::vector<Finding> SequentialFrontEnd::tick(TimeNs tick) {
  closed_step_.reset();
  // Half a tick of tolerance, since a step is a whole number of ticks except for rounding.
  const double due = config_.sequential.step - 0.5 * config_.tick;
  if (last_step_ && to_seconds(tick - *last_step_) < due) return {};

  const std::optional<TimeNs> from = last_step_;
  last_step_ = tick;
  closed_step_ = tick;
  const std::optional<Alignment> alignment = matcher_->advance();
  if (!alignment || !from) return {};
  return {to_displacement(*alignment, *from, tick)};
}

TrackDisplacement SequentialFrontEnd::to_displacement(const Alignment& alignment, TimeNs from,
                                                      TimeNs to) const {
  const SequentialConfig& config = config_.sequential;
  TrackDisplacement result;
  result.from = from;
  result.to = to;
  result.source = name_of(config_.front_end);
  result.valid = alignment.valid;
  result.distance_m = -config.k * alignment.subcolumn;
  result.sigma_m = std::hypot(config.sigma, config.k * std::sqrt(alignment.variance));
  result.score = 1.0 - alignment.distance;
  return result;
}

void SequentialFrontEnd::reset() {
  filter_.reset();
  matcher_->reset();
  first_trace_.reset();
  last_trace_.reset();
  last_step_.reset();
  closed_step_.reset();
}

std::optional<SubsurfaceFeatureMatrix> SequentialFrontEnd::sfm() const {
  if (!config_.sequential.publish_sfm || !closed_step_ || matcher_->levels() == nullptr) {
    return std::nullopt;
  }
  SubsurfaceFeatureMatrix result;
  result.time = *closed_step_;
  result.level = *matcher_->levels();
  result.column_spacing_s =
      trace_interval_s_ * config_.sequential.window_traces / config_.sequential.columns;
  return result;
}

}  // namespace gprodom::gpr
