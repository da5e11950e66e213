#include "gpr/pair/antenna_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom::gpr {
namespace {

// Traces in a mean: at 20 a second of the last 100 s, and not before 10 s.
constexpr std::size_t kMost = 2000, kLeast = 200;

// Time zeros of two antennas differ by at most so many periods of the band's centre.
constexpr double kMostPeriods = 10.0;

// Of the filter's power, as a share of the mean trace's: keeps what only noise tells out of it.
constexpr double kRidge = 0.05;

// Sum of a[i + lag] b[i].
double product(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::Index lag) {
  const Eigen::Index n = a.size() - std::abs(lag);
  if (n <= 0) return 0.0;
  return a.segment(std::max<Eigen::Index>(lag, 0), n)
      .dot(b.segment(std::max<Eigen::Index>(-lag, 0), n));
}

}  // namespace

AntennaFilter::AntennaFilter(const GprFilterConfig& band)
    : period_s_(2.0 / (band.band_low + band.band_high)) {}

void AntennaFilter::learn(const GprTrace& trace) {
  Mean& mean = means_[trace.antenna_id];
  const TraceFormat format = format_of(trace);
  if (mean.traces == 0 || !same_format(mean.format, format))
    mean = {format, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(trace.samples.size())), 0};
  mean.traces = std::min(mean.traces + 1, kMost);
  const Eigen::Map<const Eigen::VectorXf> samples(trace.samples.data(), mean.trace.size());
  mean.trace += (samples.cast<double>() - mean.trace) / static_cast<double>(mean.traces);
}

const AntennaFilter::Mean* AntennaFilter::mean_of(int antenna) const {
  const auto mean = means_.find(antenna);
  return mean == means_.end() || mean->second.traces < kLeast ? nullptr : &mean->second;
}

// Wiener filter h of 2 reach + 1 samples round the lag at which the two agree best:
// (R + ridge) h = r, with R the correlation of `from` with itself and r that of `to` with it.
GprTrace AntennaFilter::as_of(int to, GprTrace trace) const {
  const Mean* own = mean_of(trace.antenna_id);
  const Mean* other = mean_of(to);
  if (own == nullptr || other == nullptr || own == other ||
      !same_format(own->format, other->format) || !same_format(own->format, format_of(trace)))
    return trace;
  const Eigen::VectorXd from = own->trace.array() - own->trace.mean();
  const Eigen::VectorXd wanted = other->trace.array() - other->trace.mean();
  const double period = period_s_ / trace.sample_interval_s;  // samples
  const auto reach = static_cast<Eigen::Index>(std::ceil(period));
  const auto most = static_cast<Eigen::Index>(std::ceil(kMostPeriods * period));
  Eigen::Index lag = 0;
  double greatest = product(wanted, from, lag);
  for (Eigen::Index l = -most; l <= most; ++l) {
    const double here = product(wanted, from, l);
    if (here <= greatest) continue;
    greatest = here;
    lag = l;
  }
  const Eigen::Index taps = 2 * reach + 1;
  Eigen::VectorXd own_products = Eigen::VectorXd::Zero(taps), r = own_products;
  for (Eigen::Index i = 0; i < taps; ++i) {
    own_products[i] = product(from, from, i);
    r[i] = product(wanted, from, lag + i - reach);
  }
  Eigen::MatrixXd R(taps, taps);
  for (Eigen::Index i = 0; i < taps; ++i)
    for (Eigen::Index j = 0; j < taps; ++j) R(i, j) = own_products[std::abs(i - j)];
  if (!(R(0, 0) > 0.0)) return trace;
  R.diagonal().array() += kRidge * R(0, 0);
  const Eigen::VectorXf h = R.ldlt().solve(r).cast<float>();
  const auto n = static_cast<Eigen::Index>(trace.samples.size());
  const Eigen::Map<const Eigen::VectorXf> samples(trace.samples.data(), n);
  std::vector<float> filtered(trace.samples.size(), 0.0F);
  Eigen::Map<Eigen::VectorXf> sum(filtered.data(), n);
  for (Eigen::Index i = 0; i < taps; ++i) {
    const Eigen::Index shift = lag + i - reach, begin = std::max<Eigen::Index>(shift, 0);
    const Eigen::Index count = n - std::abs(shift);
    if (count > 0) sum.segment(begin, count) += h[i] * samples.segment(begin - shift, count);
  }
  trace.samples = std::move(filtered);
  return trace;
}

}  // namespace gprodom::gpr
