#include "gpr/pair/antenna_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace gprodom::gpr {
namespace {

// Traces in a mean: at 20 a second of the last 100 s, and not before 10 s.
constexpr std::size_t kMost = 2000, kLeast = 200;

// Time zeros of two antennas differ by at most so many periods of the band's centre.
constexpr double kMostPeriods = 10.0;

// Power of what is noise in a mean trace, as a share of it: keeps what only noise tells out of the
// filter. From 0.01 to 0.2 the correlation of two antennas is the same within 0.02 (six drives, two
// antennas each, also with time zero 1 ns further apart).
constexpr double kRidge = 0.05;

// Sum of a[i + lag] b[i].
double product(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::Index lag) {
  const Eigen::Index n = a.size() - std::abs(lag);
  if (n <= 0) return 0.0;
  return a.segment(std::max<Eigen::Index>(lag, 0), n)
      .dot(b.segment(std::max<Eigen::Index>(-lag, 0), n));
}

// The lag at which the two agree best, of at most so many samples.
Eigen::Index best_lag(const Eigen::VectorXd& wanted, const Eigen::VectorXd& from,
                      Eigen::Index most) {
  Eigen::Index lag = 0;
  double greatest = product(wanted, from, lag);
  for (Eigen::Index l = -most; l <= most; ++l) {
    const double here = product(wanted, from, l);
    if (here <= greatest) continue;
    greatest = here;
    lag = l;
  }
  return lag;
}

// The first sample of the filter is for a delay of `begin` samples. Wiener: (R + ridge) h = r, with
// R the correlation of `from` with itself and r that of `wanted` with it. Zero without a signal.
Eigen::VectorXf wiener(const Eigen::VectorXd& wanted, const Eigen::VectorXd& from,
                       Eigen::Index begin, Eigen::Index taps) {
  Eigen::VectorXd own = Eigen::VectorXd::Zero(taps), r = own;
  for (Eigen::Index i = 0; i < taps; ++i) {
    own[i] = product(from, from, i);
    r[i] = product(wanted, from, begin + i);
  }
  if (!(own[0] > 0.0)) return Eigen::VectorXf::Zero(taps);
  Eigen::MatrixXd R(taps, taps);
  for (Eigen::Index i = 0; i < taps; ++i)
    for (Eigen::Index j = 0; j < taps; ++j) R(i, j) = own[std::abs(i - j)];
  R.diagonal().array() += kRidge * own[0];
  return R.ldlt().solve(r).cast<float>();
}

std::vector<float> filtered(const std::vector<float>& samples, const Eigen::VectorXf& h,
                            Eigen::Index begin) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  const Eigen::Map<const Eigen::VectorXf> in(samples.data(), n);
  std::vector<float> out(samples.size(), 0.0F);
  Eigen::Map<Eigen::VectorXf> sum(out.data(), n);
  for (Eigen::Index i = 0; i < h.size(); ++i) {
    const Eigen::Index delay = begin + i, first = std::max<Eigen::Index>(delay, 0);
    const Eigen::Index count = n - std::abs(delay);
    if (count > 0) sum.segment(first, count) += h[i] * in.segment(first - delay, count);
  }
  return out;
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
  const Eigen::Index begin = best_lag(wanted, from, most) - reach;
  trace.samples = filtered(trace.samples, wiener(wanted, from, begin, 2 * reach + 1), begin);
  return trace;
}

}  // namespace gprodom::gpr
