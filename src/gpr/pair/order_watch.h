// Whether the antennas stand in the order that gpr.antennas says, or the other way round: with
// their cables swapped, or their ids. Which one leads is known where the direction of motion is, so
// that each patch of ground is compared both ways: a log likelihood ratio over independent patches.
#pragma once

namespace gprodom::gpr {

class OrderWatch {
 public:
  // One patch of ground that was not compared before. The evidence (alongside.h) of its best place
  // with the antennas as configured, and with them swapped; 0 where there is none.
  void compared(double as_configured, double swapped);

  // What was compared says that they are swapped, until as much says the contrary.
  bool swapped() const { return swapped_; }
  // It speaks for swapped, if only a little.
  bool doubted() const { return swapped_ || ratio_ > 0; }
  // It says that they are as configured.
  bool confirmed() const;

 private:
  double ratio_ = 0.0;  // log likelihood of swapped over as configured
  bool swapped_ = false;
};

}  // namespace gprodom::gpr
