#include "gpr/revisit/patch_filter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/median.h"
#include "base/processor.h"
#include "base/require.h"

namespace gprodom::gpr {
namespace {

constexpr int kLags = 64;  // of the autocorrelation over depth

// The next running mean: a row enters the sum and one leaves it.
GPRODOM_ALSO_FOR_AVX2
void next_mean(const float* __restrict enters, const float* __restrict leaves, double count,
               Eigen::Index width, double* __restrict sum, float* __restrict mean) {
  for (Eigen::Index k = 0; k < width; ++k) {
    sum[k] = sum[k] + enters[k] - leaves[k];
    mean[k] = static_cast<float>(sum[k] / count);
  }
}

// Mean over 2 * half + 1 columns, fewer at the ends.
void running_mean(Eigen::Index half, const Columns& in, Columns& out) {
  const Eigen::Index n = in.rows(), width = in.cols();
  out.resize(n, width);
  const Eigen::RowVectorXf none = Eigen::RowVectorXf::Zero(width);
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(width);
  for (Eigen::Index i = 0; i < std::min(n, half); ++i) sum += in.row(i).cast<double>();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index newest = i + half, gone = i - half - 1;
    const auto count =
        static_cast<double>(std::min(n - 1, newest) - std::max<Eigen::Index>(-1, gone));
    next_mean(newest < n ? &in(newest, 0) : none.data(), gone >= 0 ? &in(gone, 0) : none.data(),
              count, width, sum.data(), &out(i, 0));
  }
}

int half_width(double sigma) {
  return static_cast<int>(std::lround((std::sqrt(4.0 * sigma * sigma + 1.0) - 1.0) / 2.0));
}

void band_pass(double long_sigma, double short_sigma, Columns& columns) {
  Columns slow = columns;
  smooth_along(long_sigma, slow);
  columns -= slow;
  smooth_along(short_sigma, columns);
}

Eigen::ArrayXd row_power(const Columns& columns) {
  return columns.cast<double>().array().square().colwise().mean().transpose();
}

// Smooths by a Gaussian of `sigma` samples, so that the depth gain does not follow the wavelet.
Eigen::ArrayXd smooth_gain(const Eigen::ArrayXd& power, double sigma) {
  const auto n = power.size();
  const auto reach = static_cast<Eigen::Index>(std::ceil(3.0 * sigma));
  Eigen::ArrayXd smooth(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    double sum = 0.0, weight = 0.0;
    for (auto j = std::max<Eigen::Index>(0, i - reach); j <= std::min(n - 1, i + reach); ++j) {
      const double w = std::exp(-0.5 * static_cast<double>((i - j) * (i - j)) / (sigma * sigma));
      sum += w * power[j];
      weight += w;
    }
    smooth[i] = sum / weight;
  }
  return smooth;
}

// Power spectrum at frequencies k / (2 kLags) cycles per sample, k = 0 .. kLags: the transform of
// the autocorrelation of every fourth column under a Hann window of lags.
Eigen::ArrayXd power_spectrum(const Columns& columns) {
  const int lags = static_cast<int>(std::min<Eigen::Index>(kLags, columns.cols()));
  Eigen::ArrayXd correlation = Eigen::ArrayXd::Zero(kLags);
  for (Eigen::Index i = 0; i < columns.rows(); i += 4) {
    for (int lag = 0; lag < lags; ++lag) {
      const auto n = columns.cols() - lag;
      correlation[lag] += columns.row(i).head(n).dot(columns.row(i).tail(n));
    }
  }
  Eigen::ArrayXd power(kLags + 1);
  for (int k = 0; k <= kLags; ++k) {
    double sum = correlation[0];
    for (int lag = 1; lag < lags; ++lag) {
      const double hann = 0.5 + 0.5 * std::cos(M_PI * lag / lags);
      sum += 2.0 * hann * correlation[lag] * std::cos(M_PI * k * lag / kLags);
    }
    power[k] = std::max(sum, 0.0);
  }
  return power;
}

double median_bin(const Eigen::ArrayXd& power) {
  const double half = 0.5 * power.sum();
  double sum = 0.0;
  for (Eigen::Index k = 0; k < power.size(); ++k) {
    if (sum + power[k] >= half) return static_cast<double>(k) - 0.5 + (half - sum) / power[k];
    sum += power[k];
  }
  return 0.0;
}

// Zero-phase kernel for lags -(kLags - 1) .. kLags - 1. It makes `power` flat between the cuts
// (bins, at half gain; each edge is a quarter of its cut wide on either side) and removes the rest.
Eigen::ArrayXd whitening_kernel(const Eigen::ArrayXd& power, double low, double high,
                                double relative_floor) {
  const double floor = relative_floor * power.maxCoeff();
  Eigen::ArrayXd gain(kLags + 1);
  for (int k = 0; k <= kLags; ++k) {
    const double up = std::clamp((k / low - 0.75) / 0.5, 0.0, 1.0);
    const double down = std::clamp((1.125 - k / high) / 0.25, 0.0, 1.0);
    gain[k] = up * down / std::sqrt(power[k] + floor);
  }
  Eigen::ArrayXd kernel(2 * kLags - 1);
  for (int lag = 0; lag < kLags; ++lag) {
    double sum = 0.5 * gain[0];
    for (int k = 1; k <= kLags; ++k) sum += gain[k] * std::cos(M_PI * k * lag / kLags);
    kernel[kLags - 1 + lag] = kernel[kLags - 1 - lag] = sum / kLags;
  }
  return kernel;
}

// High-pass matrix (samples, samples): removes what lies below `cut` cycles per sample (half gain),
// the mean included. An offset or a slow drift of the receiver is not an echo.
Columns without_wow(Eigen::Index samples, double cut) {
  Columns mean = Columns::Identity(samples, samples);
  smooth_along(gaussian_of(cut), mean);
  return Columns::Identity(samples, samples) - mean;
}

void check_input(const Columns& traces, double spacing, double sample_interval) {
  require(traces.rows() >= 16 && traces.cols() >= 16,
          "traces: expected at least 16 of at least 16 samples");
  require(spacing > 0.0 && sample_interval > 0.0,
          "expected a spacing (m) and a sample interval (s) above 0");
  require(traces.allFinite(), "traces: not all values are finite");
}

}  // namespace

double gaussian_of(double cut) { return std::sqrt(0.5 * std::log(2.0)) / (M_PI * cut); }

void smooth_along(double sigma, Columns& columns) {
  const int half = half_width(sigma);
  if (half < 1) return;
  Columns other;
  running_mean(half, columns, other);
  running_mean(half, other, columns);
  running_mean(half, columns, other);
  columns.swap(other);
}

int repair_columns(Columns& columns) {
  constexpr float kOutlier = 6.0F;  // times the median over the columns
  const Eigen::Index n = columns.rows();
  if (n < 5) return 0;
  // All rows are scaled alike, or the direct wave alone would decide.
  const Columns rough = columns.bottomRows(n - 1) - columns.topRows(n - 1);
  Eigen::RowVectorXf scale = rough.cwiseAbs().colwise().mean();
  scale = scale.cwiseMax(std::max(1e-30F, 1e-6F * scale.maxCoeff())).cwiseInverse();
  Eigen::VectorXf unlike = Eigen::VectorXf::Zero(n);
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    unlike[i] = (columns.row(i) - 0.5F * (columns.row(i - 1) + columns.row(i + 1)))
                    .cwiseProduct(scale)
                    .cwiseAbs()
                    .cwiseMin(50.0F)
                    .mean();
  }
  const float limit =
      kOutlier * median(std::vector<float>(unlike.data() + 1, unlike.data() + n - 1));
  int repaired = 0;
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    // The neighbours of a glitch differ by half as much as the glitch. Only the glitch is replaced.
    if (unlike[i] <= limit || unlike[i] < unlike[i - 1] || unlike[i] < unlike[i + 1]) continue;
    columns.row(i) = 0.5F * (columns.row(i - 1) + columns.row(i + 1));
    ++repaired;
  }
  return repaired;
}

PatchFilter::PatchFilter(LearntPatchFilter learnt) : learnt_(std::move(learnt)) {
  const bool sound = learnt_.projection.size() > 0 && learnt_.projection.allFinite() &&
                     learnt_.row_interval > 0 && learnt_.centre > 0 && learnt_.long_sigma > 0 &&
                     learnt_.long_sigma < 1e4 && learnt_.short_sigma >= 0 &&
                     learnt_.short_sigma < 1e4;
  require(sound, "patch filter: a figure of it is out of range");
}

PatchFilter::PatchFilter(const Columns& traces, double spacing, double sample_interval,
                         const PatchFilterOptions& options) {
  check_input(traces, spacing, sample_interval);
  Columns repaired = traces;
  repair_columns(repaired);
  learn_projection(repaired, spacing, sample_interval, options);
  weigh_rows(repaired, options.taken_out > 0.0);
}

void PatchFilter::learn_projection(const Columns& traces, double spacing, double sample_interval,
                                   const PatchFilterOptions& options) {
  const auto set_cuts = [&](double wavelength) {
    learnt_.long_sigma = options.taken_out;
    if (options.taken_out <= 0.0)
      learnt_.long_sigma = std::min(options.max_long_cut, options.long_cut * wavelength) / spacing;
    learnt_.short_sigma = options.short_cut * wavelength / spacing;
  };
  set_cuts(options.max_long_cut / options.long_cut);
  Columns varying = traces;
  if (options.taken_out <= 0.0) band_pass(learnt_.long_sigma, 0.0, varying);
  const double bin = 0.5 / (kLags * sample_interval);  // Hz
  // Without gain, most of the variation is shallow and at the radar's own frequencies. With gain,
  // the slow drift of the receiver would dominate the echoes at depth.
  const double radar = median_bin(power_spectrum(varying)) * bin;
  const Columns dewow =
      without_wow(traces.cols(), std::max(options.low_cut * radar, bin) * sample_interval);
  varying = (varying * dewow.transpose()).eval();
  // Echoes that the gain amplifies at depth have a lower frequency; a higher one is noise.
  const double highest = median_bin(power_spectrum(varying)) * bin;
  const double period = 8.0;  // samples; only for the smoothness of the gain
  Eigen::ArrayXd deviation = smooth_gain(row_power(varying), 0.5 * period).sqrt();
  require(deviation.maxCoeff() > 0.0, "traces: nothing changes along the track");
  const Eigen::RowVectorXf gain =
      deviation.max(1e-9 * deviation.maxCoeff()).inverse().matrix().transpose().cast<float>();
  varying.array().rowwise() *= gain.array();

  const Eigen::ArrayXd power = power_spectrum(varying);
  learnt_.centre = std::max(0.5 * bin, std::min(median_bin(power) * bin, highest));
  set_cuts(options.wave_speed / learnt_.centre);
  const double high = options.high_cut * learnt_.centre;
  const Eigen::ArrayXd kernel = whitening_kernel(power, options.low_cut * learnt_.centre / bin,
                                                 high / bin, options.spectrum_floor);

  // The row interval is what the upper edge of the band needs, with at most max_rows rows.
  const int samples = static_cast<int>(traces.cols());
  const int needed = std::max({1, static_cast<int>(0.5 / (1.125 * high * sample_interval)),
                               (samples + options.max_rows - 1) / options.max_rows});
  const int step = options.row_step > 0 ? options.row_step : needed;
  learnt_.row_interval = step * sample_interval;
  learnt_.projection = Columns::Zero((samples + step - 1) / step, samples);
  for (int row = 0; row < rows(); ++row) {
    for (int j = 0; j < samples; ++j) {
      const int lag = j - row * step;
      if (std::abs(lag) < kLags) {
        learnt_.projection(row, j) = static_cast<float>(kernel[kLags - 1 + lag]) * gain[j];
      }
    }
  }
  learnt_.projection = (learnt_.projection * dewow).eval();
}

Columns PatchFilter::project(const Columns& traces) const {
  return traces * learnt_.projection.transpose();
}

// Scales each row to unit variance times its share of signal. The noise is read from the second
// difference between traces, which has 6 times its power: the ground cannot change that fast.
void PatchFilter::weigh_rows(const Columns& traces, bool without_mean) {
  const auto pass = [&](Columns& columns) {
    if (without_mean) {
      smooth_along(learnt_.short_sigma, columns);
    } else {
      band_pass_along(columns);
    }
  };
  Columns features = project(traces);
  const Eigen::Index n = features.rows();
  const Eigen::ArrayXd second = row_power(
      features.topRows(n - 2) - 2.0F * features.middleRows(1, n - 2) + features.bottomRows(n - 2));
  pass(features);
  const Eigen::ArrayXd power = row_power(features);
  Columns impulse = Columns::Zero(2 * static_cast<int>(4 * learnt_.long_sigma + 8) + 1, 1);
  impulse(impulse.rows() / 2, 0) = 1.0F;
  pass(impulse);
  const double passed = impulse.squaredNorm();  // of white noise along the track
  const double largest = power.maxCoeff();
  for (int row = 0; row < rows(); ++row) {
    const double noise = second[row] / 6.0 * passed;
    const double signal = power[row] > 1e-12 * largest ? 1.0 - noise / power[row] : 0.0;
    learnt_.projection.row(row) *=
        signal > 0.0 ? static_cast<float>(signal / std::sqrt(power[row])) : 0.0F;
  }
}

void PatchFilter::band_pass_along(Columns& features) const {
  band_pass(learnt_.long_sigma, learnt_.short_sigma, features);
}

Columns PatchFilter::apply(const Columns& traces) const {
  Columns repaired = traces;
  repair_columns(repaired);
  Columns features = project(repaired);
  band_pass_along(features);
  return features;
}

}  // namespace gprodom::gpr
