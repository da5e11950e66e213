#include "pipeline/factor_queue.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "estimation/cost_function_factor.h"

namespace gprodom {

namespace {

constexpr std::size_t kMostWaiting = 2000;

}  // namespace

std::string FactorQueue::add(UserFactor factor, TimeNs oldest, TimeNs latest) {
  std::string wrong = malformed(factor);
  if (!wrong.empty()) return wrong;
  if (factor.times.front() < oldest) return kOlderThanWindow;
  if (factor.times.back() > latest) return "too far ahead of the IMU";
  if (waiting_.size() >= kMostWaiting) return "too many factors wait for the IMU";
  waiting_.push_back(std::move(factor));
  return "";
}

std::vector<UserFactor> FactorQueue::take(TimeNs to) {
  const auto later = std::stable_partition(
      waiting_.begin(), waiting_.end(), [to](const UserFactor& f) { return f.times.back() <= to; });
  std::vector<UserFactor> due(std::make_move_iterator(waiting_.begin()),
                              std::make_move_iterator(later));
  waiting_.erase(waiting_.begin(), later);
  return due;
}

}  // namespace gprodom
