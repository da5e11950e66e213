// Detects glitches of the receiver: single traces, or samples of one, that are unlike the traces
// before and after them. It waits for the next trace, so it needs no threshold in counts, and a
// change that lasts is none.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace gprodom::gpr {

class GlitchCheck {
 public:
  // Of three traces in a row, whether the middle one is a glitch (never where lengths differ):
  // its mean squared difference from the mean of the others is far above the usual one (median of
  // the last 64) and far above what the others differ by. Each sample is divided by its usual
  // difference from trace to trace, or the direct wave alone would decide.
  bool is_glitch(const Eigen::RowVectorXf& before, const Eigen::RowVectorXf& trace,
                 const Eigen::RowVectorXf& after);

 private:
  float usual() const;

  static constexpr std::size_t kRecent = 64;

  Eigen::RowVectorXf step_;  // usual difference from trace to trace, of each sample
  std::array<float, kRecent> recent_{};
  std::size_t seen_ = 0;
};

}  // namespace gprodom::gpr
