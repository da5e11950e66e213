#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/median.h"
#include "gpr/revisit/revisit.h"

namespace gprodom::gpr {
namespace {

constexpr double kMostCorrelation = 0.9999;

}  // namespace

// The highest evidence at places from..to, of one direction or (null) of both.
PatchSurvey::Peak PatchSurvey::highest(double from, double to, const bool* mirrored) const {
  Peak peak;
  for (const Curves& c : curves_) {
    if (mirrored != nullptr && c.mirrored != *mirrored) continue;
    const int begin = std::max(0, static_cast<int>(std::ceil(from)) - c.first);
    const int end = std::min(c.size(), static_cast<int>(std::floor(to)) + 1 - c.first);
    for (int k = begin; k < end; ++k) {
      if (c.evidence[k] > peak.evidence) peak = {&c, k, c.evidence[k]};
    }
  }
  return peak;
}

bool PatchSurvey::beside(const Curves& curves, int entry, const Peak& peak) const {
  const int apart = std::abs(curves.first + entry - peak.place());
  return curves.mirrored == peak.curves->mirrored && apart * spacing_ <= lobe_m_;
}

// Variance of the correlation with other ground: 1 / N with N independent samples in the patch.
// Measured at all places but the peak, at the wide scale and at the peak's scale.
double PatchSurvey::chance(const Peak& peak) const {
  double sum = 0.0;
  int n = 0;
  for (const Curves& c : curves_) {
    const bool is_asked = c.wide || c.scale == peak.curves->scale;
    for (int k = 0; is_asked && k < c.size(); ++k) {
      if (beside(c, k, peak)) continue;
      sum += c.correlation[k] * c.correlation[k];
      ++n;
    }
  }
  return n > 0 ? sum / n : 1.0;
}

// Median evidence of other ground. It is above zero, since the best of several shifts is taken.
double PatchSurvey::evidence_by_chance() const {
  std::vector<double> all;
  for (const Curves& c : curves_) {
    if (c.wide) all.insert(all.end(), c.evidence.begin(), c.evidence.end());
  }
  return median(std::move(all));
}

// The log likelihood ratio is N / 4 times the evidence, since that counts each half sample twice.
Eigen::ArrayXXd PatchSurvey::log_likelihood(bool mirrored) const {
  Eigen::ArrayXXd all = Eigen::ArrayXXd::Zero(size_, static_cast<Eigen::Index>(scales_));
  if (size_ == 0) return all;
  for (const Curves& c : curves_) {
    if (c.mirrored != mirrored || !c.number) continue;
    const int begin = std::max(0, c.first - first_);
    const int n = std::min(size_, c.first + c.size() - first_) - begin;
    if (n <= 0) continue;
    all.col(static_cast<Eigen::Index>(*c.number)).segment(begin, n) =
        c.evidence.segment(begin + first_ - c.first, n);
  }
  const Peak peak = highest(first_, first_ + size_, nullptr);
  return (all - evidence_by_chance()) / (4.0 * chance(peak));
}

RevisitMatch PatchSurvey::best() const {
  const Peak peak = highest(inside_first_, inside_last_, nullptr);
  return peak.curves == nullptr ? RevisitMatch{} : judge(peak);
}

RevisitMatch PatchSurvey::around(double place, bool mirrored) const {
  const double lobe = lobe_m_ / spacing_;
  const Peak peak = highest(place - lobe, place + lobe, &mirrored);
  return peak.curves == nullptr ? RevisitMatch{} : judge(peak);
}

// Scores a peak against the second place, and checks it against correlation by chance.
RevisitMatch PatchSurvey::judge(const Peak& peak) const {
  const Curves& best = *peak.curves;
  const int at = peak.entry;
  double second = 0.0;
  for (const Curves& c : curves_) {
    for (int k = 0; k < c.size(); ++k) {
      if (!beside(c, k, peak)) second = std::max(second, c.evidence[k]);
    }
  }
  const double by_chance = chance(peak);

  RevisitMatch match;
  match.valid = true;
  match.mirrored = best.mirrored;
  match.scale = best.scale;
  match.score = peak.evidence - second;
  match.correlation = best.correlation[at];
  match.half_sigmas = std::min(best.half[0][at], best.half[1][at]) / std::sqrt(2.0 * by_chance);
  match.accepted = match.score >= min_score_ && match.half_sigmas >= min_half_;

  // Sub-column: a parabola through the evidence; the variance from the correlation's curvature.
  const double rho = std::clamp(match.correlation, 0.01, kMostCorrelation);
  double subcolumn = 0.0, curvature = 0.01 * rho;  // per column^2
  if (at > 0 && at + 1 < best.size()) {
    const double before = best.evidence[at - 1], after = best.evidence[at + 1];
    const double bend = 2.0 * peak.evidence - before - after;
    if (bend > 0.0) subcolumn = std::clamp(0.5 * (after - before) / bend, -0.5, 0.5);
    curvature = std::max(curvature, 2.0 * best.correlation[at] - best.correlation[at - 1] -
                                        best.correlation[at + 1]);
  }
  match.offset_m = (peak.place() + subcolumn + half_column_) * spacing_;
  match.sigma_m = spacing_ * std::sqrt((1.0 - rho * rho) * by_chance / (rho * curvature));
  return match;
}

}  // namespace gprodom::gpr
