#include "map/change_follower.h"

#include <algorithm>

namespace gprodom {
namespace {

constexpr double kMostStretch = 0.12;  // ln of travel times
constexpr double kMostTurn = 1.5;      // rad; an echo turned by more has another sign
constexpr double kBound = 0.1;         // m, in which the place is looked for again

}  // namespace

void ChangeFollower::follow(const gpr::TraceMemory& memory, double column,
                            const std::function<gpr::Columns(const gpr::TraceChange&)>& query) {
  if (!matcher_) matcher_.emplace(*memory.filter(), memory.spacing());
  const auto number = static_cast<std::size_t>(column);
  const gpr::MemoryRange run = memory.run_of(number);
  const auto fit = [&](const gpr::TraceChange& change) {
    const gpr::Columns now = query(change);
    const auto reach = static_cast<std::size_t>(now.rows());
    const gpr::MemoryRange near{std::max(run.first + reach, number) - reach,
                                std::min(run.end, number + reach)};
    const double middle = 0.5 * static_cast<double>(near.first + near.end - 1);
    const gpr::RevisitMatch match =
        matcher_->match(memory.patch(near), now, (column - middle) * memory.spacing(), kBound);
    return match.valid ? match.correlation : -1.0;
  };
  gpr::TraceChange tried = change_;
  if (turns_) {
    tried.turn = std::clamp(change_.turn + turn_step_, -kMostTurn, kMostTurn);
  } else {
    tried.stretch = std::clamp(change_.stretch + stretch_step_, -kMostStretch, kMostStretch);
  }
  if (fit(tried) > fit(change_)) {
    change_ = tried;
  } else {
    double& step = turns_ ? turn_step_ : stretch_step_;
    step = -step;
  }
  turns_ = !turns_;
}

}  // namespace gprodom
