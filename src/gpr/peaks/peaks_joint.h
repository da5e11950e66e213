// Joint fit of overlapping pulses: chooses the samples, the start values and the number of pulses.
#pragma once

#include <array>
#include <vector>

#include "gpr/peaks/peak.h"
#include "gpr/peaks/peaks_pulses.h"
#include "gpr/peaks/peaks_varpro.h"

namespace gprodom::gpr {

// Fits 1..kMaxJointPulses neighbouring pulses of one trace together.
//
// Samples: the gate of each pulse begins at its envelope maximum and ends at the gate's end, or at
// the valley before the next pulse if that comes first, because the model does not contain a
// pulse's rise. After a first fit, the gate is extended backwards over samples that the curve
// predicts within 2.5 standard deviations and better than the earlier pulses alone. Likewise the
// earlier pulse's gate is extended forwards into the valley. Then all is fitted again. For a pulse
// with a sharp onset this finds the onset; a pulse with a slow rise keeps its gate.
//
// Number of pulses: the least significant pulse is dropped if it fails the F-test, and the rest is
// fitted again. If the joint fit fails, the pulse that caused it is rejected, and the pulses on its
// two sides are fitted separately.
class JointFit {
 public:
  explicit JointFit(const PeakOptions& options);

  // Appends the accepted peaks of pulses[begin..end) of `all` to `peaks`, in order of time, and
  // counts what became of each.
  void run(const float* trace, const std::vector<Pulse>& all, int begin, int end,
           std::vector<Peak>& peaks, PeakCounts& counts);

 private:
  enum class Use { kFitted, kInsignificant };

  void fit_range(int begin, int end);
  void start(int begin, int end);
  void leave_out_lower_neighbour();
  bool fit();
  void gather();
  double prediction_error(int count, int sample) const;
  bool belongs(int k, int sample) const;
  bool widen_gates();
  int least_significant() const;
  void accept(int k);

  PeakOptions options_;
  // Of F(4, freedom) at the significance: each pulse has four parameters.
  std::array<double, kMaxGroupSamples> critical_{};
  const float* trace_ = nullptr;
  const std::vector<Pulse>* all_ = nullptr;
  std::vector<Peak>* peaks_ = nullptr;
  PeakCounts* counts_ = nullptr;
  int base_ = 0;
  std::array<Use, kMaxJointPulses> use_{};  // of pulse base_ + j

  // The fit at hand: pulses with their gates [pulse.start, stop).
  int count_ = 0;
  std::array<DampedSinusoid, kMaxJointPulses> pulse_;
  std::array<int, kMaxJointPulses> stop_{};
  std::array<int, kMaxJointPulses> origin_{};  // index in all
  GroupSamples samples_;
  GroupFit fit_;
  double variance_ = 0.0;  // of the noise
};

}  // namespace gprodom::gpr
