#include "motion/slip/ground_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/median.h"

namespace gprodom::slip {

namespace {

constexpr double kMedianOfSquares = 0.455;  // of the squares of normal errors of unit variance
// Distance of the spans that are compared, m: neighbours, and pairs whose errors of the place are
// hardly correlated. A slip seldom begins or ends within such a distance.
constexpr double kNear = 0.8, kFarFrom = 1.6, kFarTo = 2.6;
constexpr double kPriorCounts = 10.0;  // weight of the priors, in spans
constexpr double kPriorPlace = 0.12, kPriorSpan = 0.1;
constexpr double kLeastSpan = 0.05, kLeastPlace = 0.03;

}  // namespace

void GroundNoise::add(double at_m, double log_metres_per_length) {
  spans_.push_back({at_m, log_metres_per_length});
  if (spans_.size() > kMost) spans_.pop_front();
  std::vector<double> near, far;
  double near_m = 0.0, far_m = 0.0;  // sums of the distances
  for (std::size_t i = 1; i < spans_.size(); ++i) {
    for (std::size_t j = i; j-- > 0;) {
      const double apart = spans_[i].at_m - spans_[j].at_m;
      if (apart >= kFarTo) break;
      const double square = std::pow(spans_[i].x - spans_[j].x, 2);
      if (apart < kNear) {
        near.push_back(square);
        near_m += apart;
      } else if (apart >= kFarFrom) {
        far.push_back(square);
        far_m += apart;
      }
    }
  }
  if (near.size() < 5 || far.size() < 5) return;
  const auto correlation = [](double sum_m, std::size_t pairs) {
    return std::exp(-sum_m / static_cast<double>(pairs) / kPlace);
  };
  const double correlation_near = correlation(near_m, near.size()),
               correlation_far = correlation(far_m, far.size());
  const double half_near = 0.5 * median(near) / kMedianOfSquares,
               half_far = 0.5 * median(far) / kMedianOfSquares;
  const double place = std::max(0.0, (half_far - half_near) / (correlation_near - correlation_far));
  const double span = std::max(0.0, half_near - place * (1 - correlation_near));

  const double count = static_cast<double>(spans_.size());
  const double weight = count / (count + kPriorCounts);
  const auto sigma = [weight](double variance, double prior, double least) {
    return std::max(least, std::sqrt(weight * variance + (1 - weight) * prior * prior));
  };
  place_sigma_ = sigma(place, kPriorPlace, kLeastPlace);
  span_sigma_ = sigma(span, kPriorSpan, kLeastSpan);
}

}  // namespace gprodom::slip
