#include "gpr/pair/spectra.h"

#include <algorithm>
#include <cmath>

namespace gprodom::gpr {

namespace {

constexpr int kMostFrequencies = 16;  // bounds the work for long traces

}  // namespace

// Blocks overlap by half, under a Hann window. Frequencies closer together than one over the
// block's length would repeat each other.
Spectra::Spectra(const TraceFormat& format, const GprFilterConfig& band) {
  const auto samples = static_cast<Eigen::Index>(format.samples);
  length_ = 2 * samples / (kDepthBlocks + 1);
  for (int k = 0; k < kDepthBlocks; ++k)
    begin_.push_back(k * (samples - length_) / (kDepthBlocks - 1));
  const double dt = format.sample_interval_s, low = band.band_low;
  const double high = std::min(band.band_high, 0.5 / dt);
  const double resolution = 1 / (static_cast<double>(length_) * dt);
  const double spacing = std::max(resolution, (high - low) / (kMostFrequencies - 1));
  frequencies_ = static_cast<int>((high - low) / spacing) + 1;
  transform_.resize(2 * frequencies_, length_);
  for (Eigen::Index i = 0; i < length_; ++i) {
    const double window = 0.5 - 0.5 * std::cos(2 * M_PI * (static_cast<double>(i) + 0.5) /
                                               static_cast<double>(length_));
    for (int f = 0; f < frequencies_; ++f) {
      const double phase = 2 * M_PI * (low + f * spacing) * dt * static_cast<double>(i);
      transform_(2 * f, i) = static_cast<float>(window * std::cos(phase));
      transform_(2 * f + 1, i) = static_cast<float>(-window * std::sin(phase));
    }
  }
}

Eigen::VectorXf Spectra::of(const std::vector<float>& samples) const {
  const Eigen::Map<const Eigen::VectorXf> trace(samples.data(),
                                                static_cast<Eigen::Index>(samples.size()));
  Eigen::VectorXf spectra(size());
  for (int k = 0; k < kDepthBlocks; ++k)
    spectra.segment(2 * k * frequencies_, 2 * frequencies_).noalias() =
        transform_ * trace.segment(begin_[k], length_);
  return spectra;
}

}  // namespace gprodom::gpr
