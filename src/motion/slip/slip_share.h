// Share of the path on which the wheel slips, learnt while driving.
#pragma once

namespace gprodom::slip {

class SlipShare {
 public:
  // Seconds of rolling, and of slip in them, each as far as slip would have been seen.
  struct Counts {
    double rolled_s = 0.0, slipped_s = 0.0;
  };

  explicit SlipShare(double prior);

  // slips: probability that the wheel slipped. seen: share of the prior's variance of slip that was
  // taken away by what was measured. Where nothing would show slip, nothing is learnt.
  void add(double seconds, double slips, double seen);

  double value() const;
  const Counts& counts() const { return counts_; }
  // Those of an earlier run. They count as kEarlierCounts_s at most, since the ground may differ.
  void take_up(Counts earlier);

 private:
  static constexpr double kEarlierCounts_s = 120.0;

  double prior_;
  Counts counts_;
};

}  // namespace gprodom::slip
