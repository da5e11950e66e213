// Passages of two antennas in a row, on their way to the states: MotionJudge's part of them.
#include <algorithm>

#include "motion/motion_judge.h"

namespace gprodom {

void MotionJudge::add_passage(const AntennaPassage& passage) {
  passages_.push_back(passage);
  pair_slip_.add(passage, wheel_, newest_.state.wheel_scale);
}

std::vector<AntennaPassage> MotionJudge::take_passages(TimeNs to) {
  const auto later = std::stable_partition(passages_.begin(), passages_.end(),
                                           [to](const AntennaPassage& p) { return p.to <= to; });
  std::vector<AntennaPassage> taken(passages_.begin(), later);
  passages_.erase(passages_.begin(), later);
  return taken;
}

}  // namespace gprodom
