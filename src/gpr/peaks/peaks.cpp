#include "gpr/peaks/peaks.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace gprodom::gpr {
namespace {

constexpr double kMaxGatePeriods = 3.0;
constexpr double kOverlappingTail = 0.1;  // of the next pulse's height: a tail above it overlaps

void require_option(bool good, const char* option, const char* expected) {
  if (!good) {
    throw std::invalid_argument(std::string("peaks: ") + option + " must be " + expected);
  }
}

PeakOptions checked(const PeakOptions& o) {
  require_option(std::isfinite(o.noise_sigma) && o.noise_sigma >= 0.0, "noise_sigma", "0 or more");
  require_option(o.min_snr >= 0.0, "min_snr", "0 or more");
  require_option(o.min_relative >= 0.0 && o.min_relative < 1.0, "min_relative", "in [0, 1)");
  require_option(o.gate_periods >= 1.0 && o.gate_periods <= kMaxGatePeriods, "gate_periods",
                 "in [1, 3]");
  require_option(o.max_joint >= 1 && o.max_joint <= kMaxJointPulses, "max_joint", "1, 2 or 3");
  require_option(o.significance > 0.0 && o.significance < 1.0, "significance", "in (0, 1)");
  require_option(o.max_residual > 0.0, "max_residual", "positive");
  require_option(o.max_iterations >= 1, "max_iterations", "1 or more");
  return o;
}

bool overlap(const Pulse& before, const Pulse& after) {
  const double tail = before.height * std::exp(-before.alpha * (after.maximum - before.maximum));
  return after.maximum <= before.gate_end || tail > kOverlappingTail * after.height;
}

}  // namespace

PeakExtractor::PeakExtractor(const PeakOptions& options)
    : options_(checked(options)), joint_(options) {}

const std::vector<Peak>& PeakExtractor::extract(const float* trace, std::size_t size) {
  peaks_.clear();
  peaks_.reserve(size / 2 + 1);
  ++counts_.traces;
  analytic_signal(trace, size, signal_);
  if (size < 3) return peaks_;
  const Eigen::Map<const Eigen::ArrayXf> envelope(signal_.envelope.data(),
                                                  static_cast<Eigen::Index>(size));
  const float greatest = envelope.maxCoeff<Eigen::PropagateNaN>();
  if (!(greatest > 0.0F) || !std::isfinite(greatest)) return peaks_;

  const PeakOptions& o = options_;
  const double threshold = std::max(o.min_snr * o.noise_sigma, o.min_relative * greatest);
  find_pulses(signal_, threshold, o.gate_periods, pulses_);
  counts_.pulses += pulses_.size();
  o.fit ? add_fits(trace) : add_envelope_maxima();
  return peaks_;
}

void PeakExtractor::add_envelope_maxima() {
  for (const Pulse& pulse : pulses_) {
    const EnvelopeMaximum maximum = refine_maximum(signal_.smoothed, pulse.maximum);
    Peak peak;
    peak.sample = maximum.sample;
    peak.amplitude = maximum.height;
    peak.gate_begin = pulse.maximum;
    peak.gate_end = pulse.gate_end;
    peaks_.push_back(peak);
  }
  counts_.accepted += pulses_.size();
}

// Groups of up to max_joint pulses are fitted together, if each overlaps the tail of the one
// before.
void PeakExtractor::add_fits(const float* trace) {
  const int total = static_cast<int>(pulses_.size());
  for (int begin = 0; begin < total;) {
    int end = begin + 1;
    while (end < total && end - begin < options_.max_joint &&
           overlap(pulses_[end - 1], pulses_[end]))
      ++end;
    joint_.run(trace, pulses_, begin, end, peaks_, counts_);
    begin = end;
  }
}

int depth_row(double depth, double depth_range, int rows) {
  if (!(depth >= 0.0 && depth < depth_range)) return -1;
  return std::min(static_cast<int>(depth * rows / depth_range), rows - 1);
}

}  // namespace gprodom::gpr
