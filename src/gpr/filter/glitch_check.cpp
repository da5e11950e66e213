#include "gpr/filter/glitch_check.h"

#include <algorithm>
#include <vector>

#include "base/median.h"

namespace gprodom::gpr {
namespace {

// Squares of ratios of standard deviations: 6 times the usual difference, 3 times that between the
// two neighbours.
constexpr float kFarFromUsual = 36.0F;
constexpr float kFarFromBoth = 9.0F;

}  // namespace

bool GlitchCheck::is_glitch(const Eigen::RowVectorXf& before, const Eigen::RowVectorXf& trace,
                            const Eigen::RowVectorXf& after) {
  if (before.size() != after.size() || trace.size() != after.size()) return false;
  const Eigen::RowVectorXf step = (after - before).cwiseAbs();
  if (step_.size() != step.size()) {
    step_ = step;
    seen_ = 0;
  }
  const float rate = 1.0F / static_cast<float>(std::min(seen_ + 1, kRecent));
  step_ += rate * (step - step_);
  const float least = std::max(1e-30F, 1e-6F * step_.maxCoeff());
  const Eigen::RowVectorXf weight = step_.cwiseMax(least).cwiseInverse();
  const auto n = static_cast<float>(step.size());
  const float unlike = (trace - 0.5F * (before + after)).cwiseProduct(weight).squaredNorm() / n;
  const float apart = step.cwiseProduct(weight).squaredNorm() / n;
  const bool glitch =
      seen_ >= kRecent / 4 && unlike > kFarFromUsual * usual() && unlike > kFarFromBoth * apart;
  recent_[seen_++ % kRecent] = unlike;
  return glitch;
}

float GlitchCheck::usual() const {
  const std::size_t n = std::min(seen_, kRecent);
  return median(std::vector<float>(recent_.data(), recent_.data() + n));
}

}  // namespace gprodom::gpr
