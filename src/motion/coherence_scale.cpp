#include "motion/coherence_scale.h"

#include <algorithm>
#include <cmath>

#include "motion/radar_finding.h"

namespace gprodom {

namespace {

constexpr TimeNs kSettle = 500'000'000;   // ns; a slip is flagged within this time
constexpr TimeNs kKept = 5'000'000'000;   // ns of track kept: a span of 1 s, and its delay
constexpr TimeNs kStep = 20'000'000;      // ns between places kept
constexpr double kPriorSigma = 0.3;       // of x
constexpr double kPriorWeight_m = 3.0;    // metres that the prior counts for
constexpr double kSharedGround = 2.0;     // variance of spans in a row over that of one
constexpr double kVarianceDoubles = 8.0;  // times kLearntOver, driven without learning
// Of a span's distance. The best ground measured has 0.07 (docs/observability.md): a few spans that
// agree by chance do not make it better than this.
constexpr double kLeastRelativeSigma = 0.05;
constexpr double kMinSpeed = 0.05;          // m/s, mean over a span to learn from
constexpr std::size_t kMostWaiting = 1000;  // before the first estimate
constexpr std::int32_t kUnusable = kStanding | kSlipping | kNoWheel | kImuGap | kSolverFailed;

}  // namespace

CoherenceScale::CoherenceScale()
    : variance_weight_(kPriorWeight_m), variance_sum_(kPriorWeight_m * kPriorSigma * kPriorSigma) {}

void CoherenceScale::add(const OdometryEstimate& estimate, bool speed_known) {
  const bool can_use = speed_known && (estimate.flags & kUnusable) == 0;
  if (!can_use) unusable_.push_back(estimate.time);
  if (!track_.empty() && estimate.time < track_.end() + kStep) return;
  const double moved = track_.advance(estimate.time, std::abs(estimate.v_body.x()));
  if (!can_use) unlearned_m_ += moved;
  while (!waiting_.empty() && waiting_.front().to + kSettle <= estimate.time) {
    learn(waiting_.front());
    waiting_.pop_front();
  }
  track_.forget_before(estimate.time - kKept);
  while (!unusable_.empty() && unusable_.front() < estimate.time - kKept) unusable_.pop_front();
}

void CoherenceScale::learn(const gpr::PathLength& path) {
  if (path.from - kSettle < track_.begin() || !usable(path.from - kSettle, path.to + kSettle))
    return;
  const double metres = track_.path(path.to) - track_.path(path.from);
  if (metres < kMinSpeed * to_seconds(path.to - path.from)) return;
  const double x = std::log(metres / path.lengths);
  if (weight_ > 0.0) {
    const double deviation = x - sum_ / weight_;
    const double keep = std::exp(-metres / (4 * kLearntOver));
    variance_sum_ = keep * variance_sum_ + metres * deviation * deviation;
    variance_weight_ = keep * variance_weight_ + metres;
  }
  const double keep = std::exp(-metres / kLearntOver);
  sum_ = keep * sum_ + metres * x;
  weight_ = keep * weight_ + metres;
  learned_m_ += metres;
  unlearned_m_ = 0.0;
}

// What was learnt of another unit says nothing of this one, but for how much spans scatter.
void CoherenceScale::begin_unit(int unit) {
  unit_ = unit;
  waiting_.clear();
  learned_m_ = weight_ = sum_ = 0.0;
}

void CoherenceScale::learn_from(const gpr::PathLength& path) {
  if (path.unit != unit_) begin_unit(path.unit);
  waiting_.push_back(path);
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
}

Displacement CoherenceScale::to_metres(const gpr::PathLength& path) {
  if (path.valid) learn_from(path);
  Displacement d = to_displacement(path, metres_per_length());
  d.sigma_m = d.distance_m * relative_sigma();
  d.valid = path.valid && learned_m_ > 0.5 * kLearntOver;
  return d;
}

double CoherenceScale::metres_per_length() const {
  return weight_ > 0.0 ? std::exp(sum_ / weight_) : 0.0;
}

double CoherenceScale::relative_sigma() const {
  const double one =
      std::max(variance_sum_ / variance_weight_, kLeastRelativeSigma * kLeastRelativeSigma);
  return std::sqrt(one * kSharedGround * (1 + unlearned_m_ / (kVarianceDoubles * kLearntOver)));
}

bool CoherenceScale::usable(TimeNs from, TimeNs to) const {
  const auto first = std::lower_bound(unusable_.begin(), unusable_.end(), from);
  return first == unusable_.end() || *first > to;
}

}  // namespace gprodom
