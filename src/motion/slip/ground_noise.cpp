#include "motion/slip/ground_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gprodom::slip {

namespace {

constexpr double kMedian = 0.455;      // of the squares of normal errors of unit variance
constexpr double kNeighbours_m = 0.8;  // spans not further apart are neighbours
constexpr double kGuessCounts = 10.0;  // spans that the first guess counts for
constexpr double kGuess = 0.15, kGuessSpan = 0.1;
constexpr double kLeastSpan = 0.05, kLeastPlace = 0.03;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void GroundNoise::add(double at_m, double log_metres_per_length) {
  spans_.push_back({at_m, log_metres_per_length});
  if (spans_.size() > kMost) spans_.pop_front();
  std::vector<double> all, neighbours;
  for (const Span& span : spans_) all.push_back(span.x);
  const double middle = median(all);
  for (double& x : all) x = (x - middle) * (x - middle);
  for (std::size_t i = 1; i < spans_.size(); ++i)
    if (spans_[i].at_m - spans_[i - 1].at_m < kNeighbours_m)
      neighbours.push_back(std::pow(spans_[i].x - spans_[i - 1].x, 2));
  if (neighbours.size() < 5) return;

  const double seen = static_cast<double>(spans_.size());
  const double trust = seen / (seen + kGuessCounts);
  const double whole = trust * median(all) / kMedian + (1 - trust) * kGuess * kGuess;
  const double apart =
      trust * median(neighbours) / kMedian + (1 - trust) * 2 * kGuessSpan * kGuessSpan;
  const double correlation = std::exp(-0.5 * kNeighbours_m / kPlace);
  const double place = std::max((whole - 0.5 * apart) / correlation, kLeastPlace * kLeastPlace);
  place_sigma_ = std::sqrt(place);
  span_sigma_ = std::sqrt(std::max(whole - place, kLeastSpan * kLeastSpan));
}

}  // namespace gprodom::slip
