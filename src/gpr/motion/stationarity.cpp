#include "gpr/motion/stationarity.h"

#include <algorithm>
#include <cmath>

namespace gprodom::gpr {
namespace {

constexpr int kBins = 12;                   // per window
constexpr double kSigmas = 5.5;             // false alarm 2e-8 per test of Gaussian noise
constexpr double kUnknownWhite = 0.25;      // share of the samples that count as degrees of freedom
                                            // before their autocorrelation is known
constexpr double kMinSignal = 10.0;         // mean trace over noise of that mean, in power
constexpr double kLearningRate = 1.0 / 64;  // per window, of the noise level
constexpr int kRunToRaise = 5 * kBins;  // windows that must agree before a higher noise is believed
constexpr int kClippingMargin = 4;      // samples: reach of the smoothing and of the derivatives
// Of the difference of two mean traces over the noise's: gain and time zero that have drifted are
// taken out, what is left of them after seconds must not pass for motion.
constexpr double kSlack = 4.0;
constexpr double kSigma = 1e-3;  // m; motion that is not detected, bounded by tests on real ground

}  // namespace

StationarityFrontEnd::StationarityFrontEnd(double window) : window_(from_seconds(window)) {
  reset();
}

void StationarityFrontEnd::reset() {
  bin_traces_ = 0;
  last_time_ = 0;
  bins_ = 0;
  times_.assign(kBins, 0);
  noise_ = noise_samples_ = 0.0;
  run_ = 0;
  anchor_ = {};
  spans_.clear();
  told_ = 0;
  sights_.clear();
  seen_ = 0;
  clipping_.reset();
}

void StationarityFrontEnd::add_trace(const GprTrace& trace) {
  const auto n = static_cast<Eigen::Index>(trace.samples.size());
  if (n < 3) return;
  if (n != traces_.rows() || trace.sample_interval_s != sample_interval_) {
    reset();
    sample_interval_ = trace.sample_interval_s;
    traces_.setZero(n, kBins);
    sample_used_.setOnes(n, kBins);
    weight_.setZero(kBins);
    sum_.setZero(n);
    used_.setOnes(n);
    window_used_.setOnes(n);
  }
  const TimeNs step = last_time_ != 0 ? trace.time - last_time_ : 0;
  last_time_ = trace.time;
  if (bin_traces_ == 0) {
    bin_start_ = trace.time;
    bin_time_sum_ = 0;
    sum_.setZero();
    used_.setOnes();
  }
  // Weights 1 2 1 along the trace: most of the noise is above the antenna's band.
  const Eigen::Map<const Eigen::VectorXf> raw(trace.samples.data(), n);
  sum_.segment(1, n - 2) +=
      0.25f * (raw.head(n - 2) + raw.tail(n - 2)) + 0.5f * raw.segment(1, n - 2);
  sum_[0] += 0.75f * raw[0] + 0.25f * raw[1];
  sum_[n - 1] += 0.75f * raw[n - 1] + 0.25f * raw[n - 2];
  clipping_.mark(trace.samples, kClippingMargin, used_.data());
  bin_time_sum_ += trace.time - bin_start_;
  ++bin_traces_;
  // Closes the bin, unless another trace is expected well before its end.
  if (step > 0 && trace.time - bin_start_ + step > (window_ / kBins) * 3 / 4) close_bin();
}

void StationarityFrontEnd::forget_bins(int count) {
  bins_ -= count;
  for (int i = 0; count > 0 && i < bins_; ++i) {
    traces_.col(i) = traces_.col(i + count);
    sample_used_.col(i) = sample_used_.col(i + count);
    weight_[i] = weight_[i + count];
    times_[i] = times_[i + count];
  }
}

void StationarityFrontEnd::close_bin() {
  if (bins_ == kBins) forget_bins(1);
  traces_.col(bins_) = sum_ / static_cast<float>(bin_traces_);
  sample_used_.col(bins_) = used_;
  weight_[bins_] = static_cast<float>(bin_traces_);
  times_[bins_] = bin_start_ + bin_time_sum_ / bin_traces_;
  ++bins_;
  bin_traces_ = 0;
  // Slow radars fill the window with fewer bins.
  int first = 0;
  while (first < bins_ - 1 && times_[bins_ - 1] - times_[first] > window_) ++first;
  forget_bins(first);
  if (bins_ == kBins || times_[bins_ - 1] - times_[0] > window_ * 3 / 4) {
    test_window();
  } else {
    run_ = 0;
  }
}

WindowStatistics StationarityFrontEnd::analyse_window() {
  window_used_ = sample_used_.leftCols(bins_).rowwise().minCoeff();
  return analyser_.analyse(traces_.leftCols(bins_), weight_.head(bins_), window_used_);
}

double StationarityFrontEnd::samples(const WindowStatistics& s) const {
  return noise_samples_ > 0.0 ? noise_samples_ : kUnknownWhite * s.samples;
}

double StationarityFrontEnd::trend_limit(const WindowStatistics& s) const {
  return 1.0 + kSigmas * std::sqrt(2.0 / samples(s));
}

double StationarityFrontEnd::variance_limit(const WindowStatistics& s) const {
  return 1.0 + kSigmas * std::sqrt(2.0 / (samples(s) * (s.traces - 1)));
}

void StationarityFrontEnd::test_window() {
  WindowStatistics s = analyse_window();
  // A trace near the ends may be the first of a motion, so it is not judged as a spike yet.
  if (s.outlier > 2 && s.outlier < bins_ - 3 &&
      (noise_ <= 0.0 || s.variance > noise_ * variance_limit(s))) {
    weight_[s.outlier] = 0.0f;
    s = analyse_window();
  }
  const bool sees_ground = s.traces > 0 && s.signal * s.traces > kMinSignal * s.variance;
  if (sees_ground) see(s);
  if (!sees_ground || s.trend >= trend_limit(s)) {
    run_ = 0;
    return;
  }
  const int third = bins_ / 3;
  Span span{times_[third], times_[bins_ - 1 - third], 0.0};
  learn_noise(s, span);
  if (noise_ <= 0.0 || s.variance > noise_ * variance_limit(s)) return;
  span.score = s.variance / noise_;
  if (run_ > 0) span.from = std::min(span.from, std::max(run_from_, told_));
  span.since = standing_since();
  claim(span);
}

// Of the window that has just passed.
TimeNs StationarityFrontEnd::standing_since() {
  const double weight = weight_.head(bins_).sum();
  if (anchor_.weight > 0.0) {
    const Eigen::VectorXf used = anchor_.used.cwiseProduct(window_used_);
    const double share = 1.0 / weight + 1.0 / anchor_.weight;
    const double limit = 1.0 + kSigmas * std::sqrt(2.0 / noise_samples_) + kSlack;
    if (analyser_.difference(anchor_.mean, used) < limit * share * noise_) return anchor_.time;
  }
  anchor_ = {analyser_.mean(), window_used_, weight, times_[0]};
  return anchor_.time;
}

void StationarityFrontEnd::learn_noise(const WindowStatistics& s, const Span& span) {
  const double limit = variance_limit(s);
  if (run_ > 0 && (s.variance > run_variance_ * limit || run_variance_ > s.variance * limit)) {
    run_ = 0;
  }
  if (run_ == 0) {
    run_variance_ = run_samples_ = 0.0;
    run_from_ = span.from;
  }
  ++run_;
  const double share = 1.0 / std::min(run_, kBins);
  run_variance_ += share * (s.variance - run_variance_);
  run_samples_ += share * (s.white_samples - run_samples_);
  if (run_ < kBins) return;
  const bool lower = noise_ <= 0.0 || run_variance_ * limit < noise_;
  const bool higher = run_variance_ > noise_ * limit;
  if (lower || (higher && run_ >= kRunToRaise)) {
    noise_ = run_variance_;
    noise_samples_ = run_samples_;
  } else if (!higher) {
    noise_ += kLearningRate * (s.variance - noise_);
    noise_samples_ += kLearningRate * (s.white_samples - noise_samples_);
  }
}

void StationarityFrontEnd::see(const WindowStatistics& s) {
  if (noise_ <= 0.0 || times_[0] < seen_) return;
  const double n = s.traces;
  const double error = std::sqrt(2.0 / (samples(s) * (n - 1)));  // of a variance over the noise's
  const double by_variance = std::max(s.variance / noise_ - 1.0, error) * 12 / (n * (n + 1));
  const double squared = std::max(by_variance, 2.0 * (s.step / noise_ - 1.0));
  const double least = (trend_limit(s) - 1.0) * 12 / (n * (n * n - 1));
  seen_ = times_[bins_ - 1];
  sights_.push_back({times_[0], seen_, std::sqrt(squared / least)});
}

void StationarityFrontEnd::claim(const Span& span) {
  if (!spans_.empty() && span.from <= spans_.back().to)
    spans_.back() = {std::min(spans_.back().from, span.from), span.to, span.score, span.since};
  else
    spans_.push_back(span);
}

std::vector<Finding> StationarityFrontEnd::tick(TimeNs tick) {
  std::vector<Finding> result(sights_.begin(), sights_.end());
  sights_.clear();
  while (!spans_.empty()) {
    Span& span = spans_.front();
    if (span.to > told_) {
      const TimeNs from = std::max(span.from, std::min(told_, span.to) - window_);
      const TimeNs to = std::min(span.to, tick);
      if (to > from)
        result.push_back(Standstill{from, to, "stationarity", kSigma, span.score, span.since});
      told_ = to;
    }
    if (spans_.size() == 1) break;  // may still grow
    spans_.erase(spans_.begin());
  }
  return result;
}

}  // namespace gprodom::gpr
