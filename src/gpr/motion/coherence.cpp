#include "gpr/motion/coherence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/by_time.h"
#include "gpr/kernels/add_multiple.h"

namespace gprodom::gpr {
namespace {

// ns of one distance: long enough for steps that add up to more than their noise, short enough for
// a slip to show.
constexpr TimeNs kSpan = 1'000'000'000;
constexpr double kGatePeriods = 1.25;
constexpr float kMinSnr = 3.0f;      // least energy over noise of a gate that is used
constexpr float kMaxSnr = 20.0f;     // energy over noise from which on its weight stays the same
constexpr double kAnchorStep = 0.1;  // q at which the newest trace becomes the anchor
constexpr double kPartStep = 0.04;   // least q of a step that is not complete
constexpr double kTooLong = 0.75;    // share of the largest q; beyond, a step has no known length
constexpr int kFar = 10;             // anchors between two places that count as far apart
constexpr int kUnlikePlaces = 20;    // number of such pairs that are kept
constexpr float kMoved = 4.0f;    // change over noise that counts as motion while no gate is used
constexpr int kPlaces = 100;      // anchors that the background remembers
constexpr int kLevelPlaces = 50;  // anchors that a gate's usual energy remembers
constexpr float kNoiseRise = 1.003f;  // per second: twice in four minutes
// Mean fall of noise over energy with which another unit begins: half of the q of a step.
constexpr float kOtherUnit = 0.5f * static_cast<float>(kAnchorStep);
constexpr TimeNs kBlock = 1'000'000'000;
constexpr int kMinBlock = 4;  // traces

FilterOptions filter_for_coherence(const GprFilterConfig& config) {
  FilterOptions options(config);
  options.background = Background::kNone;
  options.wavelet = WaveletKind::kNone;
  options.time_zero_max = 0.0;
  options.gain_rate = options.gain_power = 0.0;
  return options;
}

void take_out(Eigen::VectorXf& x, const Eigen::VectorXf& along) {
  const float norm = along.squaredNorm();
  if (norm > 0.0f) add_multiple(-x.dot(along) / norm, along.data(), x.size(), x.data());
}

}  // namespace

DecorrelationPath::DecorrelationPath(int gate, int unit) : gate_(std::max(gate, 2)), unit_(unit) {}

void DecorrelationPath::prepare(int n) {
  const DecorrelationPath before = std::exchange(*this, DecorrelationPath(gate_));
  gates_ = std::max(n / gate_, 1);
  for (Eigen::VectorXf* v :
       {&trace_, &previous_, &anchor_, &older_, &background_, &mean_, &slope_, &curve_, &delta_})
    v->setZero(n);
  for (Eigen::ArrayXf* v : {&change_, &energy_, &level_, &noise_, &block_, &largest_noise_})
    v->setZero(gates_);
  unit_ = before.unit_;
  if (!before.knows_noise_ || before.trace_.size() < n) {
    ++unit_;
    return;
  }
  background_ = before.background_.head(n);
  level_ = before.level_.head(gates_);
  noise_ = before.noise_.head(gates_);
  largest_noise_ = before.largest_noise_.head(gates_);
  knows_noise_ = true;
  places_ = before.places_;
  unlike_ = before.unlike_;
  unlike_seen_ = before.unlike_seen_;
}

void DecorrelationPath::difference(const Eigen::VectorXf& a, const Eigen::VectorXf& b) {
  const Eigen::Index n = a.size();
  delta_ = b - a;
  mean_ = 0.5f * (a + b);
  slope_.segment(1, n - 2) = mean_.tail(n - 2) - mean_.head(n - 2);
  slope_[0] = slope_[n - 1] = 0.0f;
  curve_.segment(1, n - 2) = mean_.head(n - 2) - 2.0f * mean_.segment(1, n - 2) + mean_.tail(n - 2);
  curve_[0] = curve_[n - 1] = 0.0f;
  take_out(slope_, mean_);
  take_out(curve_, mean_);
  take_out(curve_, slope_);
  for (const Eigen::VectorXf* way : {&mean_, &slope_, &curve_}) take_out(delta_, *way);
  for (int i = 0; i < gates_; ++i)
    change_[i] = delta_.segment(static_cast<Eigen::Index>(i) * gate_, gate_).squaredNorm();
}

void DecorrelationPath::follow_noise(TimeNs time) {
  if (block_traces_ == 0) block_start_ = time;
  block_ += change_;
  ++block_traces_;
  if (time - block_start_ < kBlock || block_traces_ < kMinBlock) return;
  block_ /= static_cast<float>(block_traces_);
  if (knows_noise_)
    noise_ = (noise_ * kNoiseRise).min(block_);
  else
    noise_ = block_;
  knows_noise_ = true;
  block_.setZero();
  block_traces_ = 0;
  follow_unit();
}

void DecorrelationPath::follow_unit() {
  largest_noise_ = largest_noise_.max(noise_);
  float fall = 0.0f;
  int gates = 0;
  for (int i = 0; i < gates_; ++i) {
    if (!(level_[i] > (1.0f + kMinSnr) * noise_[i])) continue;
    fall += (largest_noise_[i] - noise_[i]) / level_[i];
    ++gates;
  }
  if (gates == 0 || fall < kOtherUnit * static_cast<float>(gates)) return;
  largest_noise_ = noise_;
  ++unit_;
}

DecorrelationPath::Similarity DecorrelationPath::compare(const Eigen::VectorXf& before) {
  for (int i = 0; i < gates_; ++i) {
    const Eigen::Index at = static_cast<Eigen::Index>(i) * gate_;
    energy_[i] = (trace_.segment(at, gate_) - background_.segment(at, gate_)).squaredNorm() +
                 (before.segment(at, gate_) - background_.segment(at, gate_)).squaredNorm();
  }
  Similarity s;
  double total = 0.0;
  usable_gates_ = 0;
  for (int i = 0; i < gates_; ++i) {
    const float snr = level_[i] / std::max(noise_[i], 1e-12f) - 1.0f;
    if (!(snr > kMinSnr)) continue;
    const double weight = std::min(snr, kMaxSnr);
    const double q = (change_[i] - noise_[i]) / (energy_[i] + 4.0f * noise_[i]);
    s.q += weight * q;
    s.step += weight * std::sqrt(std::max(q, 0.0));
    total += weight;
    ++usable_gates_;
  }
  if (total > 0.0) {
    s.q /= total;
    s.step /= total;
  }
  return s;
}

void DecorrelationPath::move_anchor() {
  anchor_ = trace_;
  ++places_;
  background_ += (trace_ - background_) / static_cast<float>(std::min(places_, kPlaces));
  if (places_ > 1)
    level_ += (energy_ - level_) / static_cast<float>(std::min(places_ - 1, kLevelPlaces));
}

void DecorrelationPath::learn_unlike() {
  if (steps_ > kFar) {
    difference(older_, trace_);
    unlike_seen_ = std::min(unlike_seen_ + 1, kUnlikePlaces);
    unlike_ += (compare(older_).q - unlike_) / unlike_seen_;
  }
  older_ = trace_;
}

void DecorrelationPath::add(const float* y, int n, TimeNs time) {
  if (n < 3) return;
  const bool first = n != trace_.size();
  if (first) prepare(n);
  trace_ = Eigen::Map<const Eigen::VectorXf>(y, n);
  if (first || interrupted_) {
    interrupted_ = false;
    previous_ = anchor_ = trace_;
    if (places_ == 0) move_anchor();
    block_.setZero();
    block_traces_ = 0;
    return;
  }
  difference(previous_, trace_);
  previous_ = trace_;
  follow_noise(time);
  if (!knows_noise_) return;
  difference(anchor_, trace_);
  const Similarity s = compare(anchor_);
  if (usable_gates_ == 0) {
    if (change_.sum() > kMoved * noise_.sum()) move_anchor();
    return;
  }
  if (s.q > kAnchorStep) {
    base_ += s.step;
    length_ = base_;
    ++steps_;
    if (s.q > kTooLong * unlike_) ++too_long_;
    move_anchor();
    if (steps_ % kFar == 0) learn_unlike();
  } else if (s.q > kPartStep) {
    length_ = std::max(length_, base_ + s.step);
  }
}

CoherenceFrontEnd::CoherenceFrontEnd(const GprConfig& config)
    : filter_(filter_for_coherence(config.filter)),
      centre_hz_(0.5 * (config.filter.band_low + config.filter.band_high)),
      path_(2) {}

void CoherenceFrontEnd::reset() {
  filter_.reset();
  path_.interrupt();
  places_.clear();
  from_ = 0;
}

void CoherenceFrontEnd::add_trace(const GprTrace& trace) {
  const auto result = filter_.filter(trace);
  if (trace.sample_interval_s != sample_interval_) {
    sample_interval_ = trace.sample_interval_s;
    path_ = DecorrelationPath(
        static_cast<int>(std::lround(kGatePeriods / centre_hz_ / sample_interval_)), path_.unit());
  }
  if (!result.samples) return;
  path_.add(result.samples, static_cast<int>(trace.samples.size()), trace.time);
  places_.push_back(
      {trace.time, path_.length(), path_.steps(), path_.steps_too_long(), path_.unit()});
}

CoherenceFrontEnd::Place CoherenceFrontEnd::at(TimeNs time) const {
  const auto next = first_after(places_, time);
  Place place = next == places_.begin() ? *next : *(next - 1);
  place.length = interpolated(places_, time, &Place::length);
  return place;
}

std::vector<Finding> CoherenceFrontEnd::tick(TimeNs tick) {
  if (places_.empty()) return {};
  const TimeNs newest = places_.back().time;
  if (from_ == 0 || newest < from_) {
    from_ = newest;
    return {};
  }
  if (newest - from_ < kSpan) return {};
  const TimeNs to = std::min(newest, tick);
  PathLength path;
  path.source = "coherence";
  path.from = std::max(from_, places_.front().time);
  path.to = to;
  const Place a = at(path.from), b = at(path.to);
  path.lengths = b.length - a.length;
  path.unit = b.unit;
  // The antenna moved during the whole span if it did not rest in any third of it.
  const int kParts = 3;
  double least = path.lengths;
  const TimeNs span = path.to - path.from;
  for (int i = 0; i < kParts; ++i)
    least = std::min(least, at(path.from + span * (i + 1) / kParts).length -
                                at(path.from + span * i / kParts).length);
  path.score = path.lengths > 0.0 ? kParts * least / path.lengths : 0.0;
  path.valid = path_.sees_ground() && a.unit == b.unit && least > 0.0 &&
               b.steps - a.steps >= kParts && 2 * (b.too_long - a.too_long) < b.steps - a.steps;
  from_ = to;
  while (places_.size() > 1 && places_[1].time <= from_) places_.pop_front();
  if (path.lengths <= 0.0) return {};
  return {path};
}

}  // namespace gprodom::gpr
