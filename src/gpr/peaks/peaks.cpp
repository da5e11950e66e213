#include "gpr/peaks/peaks.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "gpr/peaks/peaks_envelope.h"
#include "gpr/peaks/peaks_joint.h"
#include "gpr/peaks/peaks_pulses.h"

namespace gprodom::gpr {
namespace {

constexpr double kMaxGatePeriods = 3.0;
constexpr double kOverlappingTail = 0.1;  // of the next pulse's height: a tail above it overlaps

void require(bool good, const char* option, const char* expected) {
  if (!good) {
    throw std::invalid_argument(std::string("peaks: ") + option + " must be " + expected);
  }
}

void check(const PeakOptions& o) {
  require(std::isfinite(o.noise_sigma) && o.noise_sigma >= 0.0, "noise_sigma", "0 or more");
  require(o.min_snr >= 0.0, "min_snr", "0 or more");
  require(o.min_relative >= 0.0 && o.min_relative < 1.0, "min_relative", "in [0, 1)");
  require(o.gate_periods >= 1.0 && o.gate_periods <= kMaxGatePeriods, "gate_periods", "in [1, 3]");
  require(o.max_joint >= 1 && o.max_joint <= kMaxJointPulses, "max_joint", "1, 2 or 3");
  require(o.significance > 0.0 && o.significance < 1.0, "significance", "in (0, 1)");
  require(o.max_residual > 0.0, "max_residual", "positive");
  require(o.max_iterations >= 1, "max_iterations", "1 or more");
}

}  // namespace

struct PeakExtractor::Work {
  explicit Work(const PeakOptions& o)
      : options(o), f_test(o.significance), joint(options, f_test) {}

  PeakOptions options;
  FTest f_test;
  JointFit joint;
  AnalyticSignal signal;
  std::vector<Pulse> pulses;
  std::vector<Peak> peaks;
  PeakCounts counts;

  void add_envelope_maxima();
  void add_fits(const float* trace);
  bool overlap(const Pulse& before, const Pulse& after) const;
};

PeakExtractor::PeakExtractor(const PeakOptions& options) {
  check(options);
  work_ = std::make_unique<Work>(options);
}
PeakExtractor::~PeakExtractor() = default;
PeakExtractor::PeakExtractor(PeakExtractor&&) noexcept = default;
PeakExtractor& PeakExtractor::operator=(PeakExtractor&&) noexcept = default;

const PeakCounts& PeakExtractor::counts() const { return work_->counts; }
const PeakOptions& PeakExtractor::options() const { return work_->options; }

const std::vector<Peak>& PeakExtractor::extract(const float* trace, std::size_t size) {
  Work& w = *work_;
  w.peaks.clear();
  w.peaks.reserve(size / 2 + 1);
  ++w.counts.traces;
  analytic_signal(trace, size, w.signal);
  if (size < 3) return w.peaks;
  const Eigen::Map<const Eigen::ArrayXf> envelope(w.signal.envelope.data(),
                                                  static_cast<Eigen::Index>(size));
  const float greatest = envelope.maxCoeff<Eigen::PropagateNaN>();
  if (!(greatest > 0.0F) || !std::isfinite(greatest)) return w.peaks;

  const PeakOptions& o = w.options;
  const double threshold = std::max(o.min_snr * o.noise_sigma, o.min_relative * greatest);
  find_pulses(w.signal, threshold, o.gate_periods, w.pulses);
  w.counts.pulses += w.pulses.size();
  o.fit ? w.add_fits(trace) : w.add_envelope_maxima();
  return w.peaks;
}

void PeakExtractor::Work::add_envelope_maxima() {
  for (const Pulse& pulse : pulses) {
    const EnvelopeMaximum maximum = refine_maximum(signal.smoothed, pulse.maximum);
    Peak peak;
    peak.sample = maximum.sample;
    peak.amplitude = maximum.height;
    peak.gate_begin = pulse.maximum;
    peak.gate_end = pulse.gate_end;
    peaks.push_back(peak);
  }
  counts.accepted += pulses.size();
}

// Groups of up to max_joint pulses are fitted together, if each overlaps the tail of the one
// before.
bool PeakExtractor::Work::overlap(const Pulse& before, const Pulse& after) const {
  const double tail = before.height * std::exp(-before.alpha * (after.maximum - before.maximum));
  return after.maximum <= before.gate_end || tail > kOverlappingTail * after.height;
}

void PeakExtractor::Work::add_fits(const float* trace) {
  const int total = static_cast<int>(pulses.size());
  for (int begin = 0; begin < total;) {
    int end = begin + 1;
    while (
        end < total && end - begin < options.max_joint &&
        overlap(pulses[static_cast<std::size_t>(end - 1)], pulses[static_cast<std::size_t>(end)])) {
      ++end;
    }
    joint.run(trace, pulses, begin, end, peaks, counts);
    begin = end;
  }
}

int depth_row(double depth, double depth_range, int rows) {
  if (!(depth >= 0.0 && depth < depth_range)) return -1;
  return std::min(static_cast<int>(depth * rows / depth_range), rows - 1);
}

}  // namespace gprodom::gpr
