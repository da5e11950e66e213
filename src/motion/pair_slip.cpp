#include "motion/pair_slip.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

namespace {

constexpr TimeNs kMemory = 8'000'000'000;  // ns; longer than the window

// ns, from a passage's end until the path counts as unmeasured. A passage is known half a patch of
// ground after its end; slower robots and stops take longer.
constexpr TimeNs kMeasured = 4'000'000'000;

// Standard deviations of l: below it the wheel's own error counts, beyond the wheel says nothing.
constexpr double kMostSlip = 2.0;

}  // namespace

void PairSlip::add(const AntennaPassage& passage, const WheelHistory& wheel, double wheel_scale) {
  newest_ = std::max(newest_, passage.to);
  const auto from = wheel.distance(passage.from), to = wheel.distance(passage.to);
  if (!from || !to) return;
  const double moved = (passage.lever_from - passage.lever_to).x();
  const double rolled = (*to - *from) / wheel_scale;
  // A wheel that turns the other way, or hardly: there is no such l. The passage says it all.
  const double ratio = rolled * moved > 0 ? moved / rolled : std::exp(kMostSlip);
  const double l = std::clamp(std::log(ratio), -kMostSlip, kMostSlip);
  seen_.push_back({passage.from + (passage.to - passage.from) / 2, l});
  while (seen_.front().middle < seen_.back().middle - kMemory) seen_.pop_front();
}

bool PairSlip::knows(TimeNs time) const { return newest_ > 0 && time < newest_ + kMeasured; }

// The nearest passage's slip. Slip wanders as in the prior of the pose graph: over a time t by the
// variance 2 t size^2 / lasts_s.
std::vector<IntervalSlip> PairSlip::revise(std::vector<IntervalSlip> slips, TimeNs to) {
  if (!used_) return slips;
  ends_.push_back(to);
  while (ends_.front() < to - kMemory) ends_.pop_front();
  if (slips.empty())
    for (const TimeNs end : ends_) slips.push_back({end});
  if (!knows(to) || seen_.empty()) return slips;
  for (IntervalSlip& slip : slips) {
    if (slip.to < seen_.front().middle - kMeasured) continue;
    const auto distance = [&](const Seen& s) { return std::abs(s.middle - slip.to); };
    const auto nearest =
        std::min_element(seen_.begin(), seen_.end(),
                         [&](const Seen& a, const Seen& b) { return distance(a) < distance(b); });
    const double apart_s = std::max(0.5, to_seconds(distance(*nearest)));
    slip.l = nearest->l;
    slip.sigma = model_.size * std::sqrt(2 * apart_s / model_.lasts_s);
  }
  return slips;
}

}  // namespace gprodom
