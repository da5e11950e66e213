#include "motion/pair_slip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gprodom {

namespace {

// In durations of the last passage: from its end until the path counts as unmeasured. The next one
// is known half a patch and a third of the antennas' distance later, about one duration; a few may
// be missed.
constexpr TimeNs kDurationsKnown = 5;

// Standard deviations of l: below it the wheel's own error counts, beyond the wheel says nothing.
constexpr double kMostSlip = 2.0;

}  // namespace

void PairSlip::add(const AntennaPassage& passage, const WheelHistory& wheel, double wheel_scale) {
  passages_.push_back(passage);
  known_until_ = std::max(known_until_, passage.to + kDurationsKnown * (passage.to - passage.from));
  const auto from = wheel.distance(passage.from), to = wheel.distance(passage.to);
  if (!from || !to) return;
  const double moved = passage.distance_m();
  const double rolled = (*to - *from) / wheel_scale;
  // A wheel that turns the other way, or hardly: there is no such l. The passage says it all.
  const double ratio = rolled * moved > 0 ? moved / rolled : std::exp(kMostSlip);
  const double l = std::clamp(std::log(ratio), -kMostSlip, kMostSlip);
  const TimeNs lasted = passage.to - passage.from;
  const double l_sigma = passage.sigma_m / std::abs(moved);
  seen_.push_back(with_prior({passage.from + lasted / 2, lasted, l, l_sigma * l_sigma}));
  while (seen_.front().middle < seen_.back().middle - kMemory) seen_.pop_front();
}

// A weak match tells little of l beside what is likely: that l goes on as it was, or that the wheel
// grips, or that it slips. Mean and variance of the three, each with its evidence.
PairSlip::Seen PairSlip::with_prior(const Seen& measured) const {
  struct Kind {
    double weight, mean, variance;
  };
  double kept = 0.0;
  Kind as_before{0.0, 0.0, 0.0};
  if (!seen_.empty()) {
    const double seconds = std::abs(to_seconds(measured.middle - seen_.back().middle));
    kept = model_.correlation(seconds);
    as_before = {kept, seen_.back().l,
                 seen_.back().variance + model_.change * model_.change * seconds};
  }
  const std::array<Kind, 3> kinds = {
      as_before, Kind{(1 - kept) * (1 - model_.share), 0.0, model_.surface * model_.surface},
      Kind{(1 - kept) * model_.share, 0.0, model_.size * model_.size}};
  double sum = 0.0, mean = 0.0, square = 0.0;
  for (const Kind& kind : kinds) {
    const double total = kind.variance + measured.variance, error = measured.l - kind.mean;
    const double weight = kind.weight * std::exp(-0.5 * error * error / total) / std::sqrt(total);
    const double gain = kind.variance / total, l = kind.mean + gain * error;
    sum += weight;
    mean += weight * l;
    square += weight * (l * l + (1 - gain) * kind.variance);
  }
  if (sum <= 0.0) return measured;  // far from all of them
  mean /= sum;
  return {measured.middle, measured.lasted, mean, std::max(0.0, square / sum - mean * mean)};
}

bool PairSlip::knows(TimeNs time) const { return time < known_until_; }

// Each passage tells of the antennas' distance; half of that to the next one is taken as seen with
// it.
std::optional<double> PairSlip::left(TimeNs time) const {
  if (!used_) return std::nullopt;
  if (std::any_of(seen_.begin(), seen_.end(),
                  [time](const Seen& s) { return std::abs(time - s.middle) <= s.lasted; }))
    return 0.0;
  const auto slip = at(time);
  return slip ? slip->sigma : std::numeric_limits<double>::infinity();
}

// By the nearest passage, with the model of the pose graph's prior: since then another slip has
// begun, or the wheel grips, or the slip goes on. Nothing where no passage tells of it.
std::optional<IntervalSlip> PairSlip::at(TimeNs time) const {
  if (seen_.empty() || !knows(time)) return std::nullopt;
  const auto apart = [&](const Seen& s) { return std::abs(s.middle - time); };
  const Seen& nearest =
      *std::min_element(seen_.begin(), seen_.end(),
                        [&](const Seen& a, const Seen& b) { return apart(a) < apart(b); });
  const double apart_s = std::max(0.5, to_seconds(apart(nearest)));
  const double walked = model_.change * model_.change * apart_s;
  const double changed =
      (1 - model_.correlation(apart_s)) * (model_.sigma() * model_.sigma() + nearest.l * nearest.l);
  return IntervalSlip{time, nearest.l, std::sqrt(nearest.variance + walked + changed)};
}

std::vector<IntervalSlip> PairSlip::revise(std::vector<IntervalSlip> slips, TimeNs to) {
  if (!used_) return slips;
  ends_.push_back(to);
  while (ends_.front() < to - kMemory) ends_.pop_front();
  // Those of a robot that is so slow that only passages tell of them.
  std::vector<IntervalSlip> all;
  const TimeNs given_since = slips.empty() ? std::numeric_limits<TimeNs>::max() : slips.front().to;
  for (const TimeNs end : ends_) {
    const auto slip = at(end);
    if (end < given_since && (slip || slips.empty()))
      all.push_back(slip.value_or(IntervalSlip{end}));
  }
  for (const IntervalSlip& slip : slips) all.push_back(at(slip.to).value_or(slip));
  return all;
}

}  // namespace gprodom
