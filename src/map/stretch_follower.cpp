#include "map/stretch_follower.h"

#include <algorithm>

namespace gprodom {
namespace {

constexpr double kMost = 0.12;  // ln of travel times
constexpr double kBound = 0.1;  // m, in which the place is looked for again

}  // namespace

void StretchFollower::follow(const gpr::TraceMemory& memory, double column,
                             const std::function<gpr::Columns(double)>& query) {
  if (!matcher_) matcher_.emplace(*memory.filter(), memory.spacing());
  const auto number = static_cast<std::size_t>(column);
  const gpr::MemoryRange run = memory.run_of(number);
  double best = -1.0, chosen = stretch_;
  for (const double step : {0.0, step_}) {
    const gpr::Columns now = query(stretch_ + step);
    const auto reach = static_cast<std::size_t>(now.rows());
    const gpr::MemoryRange near{std::max(run.first + reach, number) - reach,
                                std::min(run.end, number + reach)};
    const double middle = 0.5 * static_cast<double>(near.first + near.end - 1);
    const gpr::RevisitMatch match =
        matcher_->match(memory.patch(near), now, (column - middle) * memory.spacing(), kBound);
    if (!match.valid || match.correlation <= best) continue;
    best = match.correlation;
    chosen = std::clamp(stretch_ + step, -kMost, kMost);
  }
  if (chosen == stretch_) step_ = -step_;
  stretch_ = chosen;
}

}  // namespace gprodom
