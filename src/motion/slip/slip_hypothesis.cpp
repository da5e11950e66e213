#include "motion/slip/slip_hypothesis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace gprodom::slip {

namespace {

// A hypothesis is dropped if its log weight is below that of the likeliest by more than this.
constexpr double kDropped = 12.0;
// Two hypotheses of one mode are merged if slip and ground (ln), and speed (m/s), differ by less.
constexpr double kAlike = 0.02, kAlikeSpeed_mps = 0.02;

bool alike(const Hypothesis& a, const Hypothesis& b) {
  const Vector difference = (a.x - b.x).cwiseAbs();
  return a.mode == b.mode && a.axes_kind == b.axes_kind && difference[row::kSlip] < kAlike &&
         difference[row::kGround] < kAlike && difference[row::kSpeed] < kAlikeSpeed_mps;
}

// Merges `b` into `a`, weighted; mean and covariance of the two together stay the same.
void merge(Hypothesis& a, const Hypothesis& b) {
  const double log_weight = a.log_weight + std::log1p(std::exp(b.log_weight - a.log_weight));
  const double share = std::exp(b.log_weight - log_weight);
  const Vector apart = b.x - a.x;
  a.x += share * apart;
  a.P = (1 - share) * a.P + share * b.P + share * (1 - share) * apart * apart.transpose();
  for (std::size_t i = 0; i < a.past.size(); ++i) {
    const double between = b.past[i].l - a.past[i].l;
    a.past[i].l += share * between;
    a.past[i].slips += share * (b.past[i].slips - a.past[i].slips);
    a.past[i].variance = (1 - share) * a.past[i].variance + share * b.past[i].variance +
                         share * (1 - share) * between * between;
  }
  a.log_weight = log_weight;
}

// Of the same kind as `h`, the one with the nearest slip; nullptr if none is of its kind.
Hypothesis* nearest(std::vector<Hypothesis>& hypotheses, const Hypothesis& h) {
  Hypothesis* found = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (Hypothesis& other : hypotheses) {
    const double apart = std::abs(other.x[row::kSlip] - h.x[row::kSlip]);
    if (other.mode != h.mode || other.axes_kind != h.axes_kind || apart >= least) continue;
    found = &other;
    least = apart;
  }
  return found;
}

}  // namespace

double Hypothesis::update(const Vector& H, double residual, double variance, double most) {
  const Vector PH = P * H;
  double S = H.dot(PH) + variance;
  double q = residual * residual / S;
  if (most > 0 && q > most * most) {
    S = residual * residual / (most * most);
    q = most * most;
  }
  x += PH * (residual / S);
  P -= PH * PH.transpose() / S;
  return -0.5 * (q + std::log(S));
}

Eigen::Matrix2d Hypothesis::axes() const {
  Eigen::Matrix2d axes = Eigen::Matrix2d::Identity();
  axes.row(0) += x.segment<2>(row::kAxes).transpose();
  axes.row(1) += x.segment<2>(row::kAxes + 2).transpose();
  return axes;
}

void Hypothesis::set_slip(double l, double sigma) {
  x[row::kSlip] = l;
  P.row(row::kSlip).setZero();
  P.col(row::kSlip).setZero();
  P(row::kSlip, row::kSlip) = sigma * sigma;
}

void prune(std::vector<Hypothesis>& hypotheses, std::size_t most) {
  std::stable_sort(
      hypotheses.begin(), hypotheses.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.log_weight > b.log_weight; });
  std::vector<Hypothesis> kept;
  std::array<std::size_t, 2> count{};  // of other axes, of the configured ones
  const double least = hypotheses.front().log_weight - kDropped;
  for (Hypothesis& h : hypotheses) {
    std::size_t& so_many = count[h.axes_kind == kConfiguredAxes];
    if (h.log_weight < least && so_many > 0) continue;
    const auto same = std::find_if(kept.begin(), kept.end(),
                                   [&](const Hypothesis& other) { return alike(other, h); });
    if (same != kept.end()) {
      merge(*same, h);
    } else if (so_many < most) {
      ++so_many;
      kept.push_back(std::move(h));
    } else if (Hypothesis* like = nearest(kept, h)) {
      // Many that are unlikely are likely together: dropped, they would make slip too improbable.
      merge(*like, h);
    }
  }
  double sum = 0.0;
  const double first = kept.front().log_weight;
  for (const Hypothesis& h : kept) sum += std::exp(h.log_weight - first);
  for (Hypothesis& h : kept) h.log_weight -= first + std::log(sum);
  hypotheses = std::move(kept);
}

}  // namespace gprodom::slip
