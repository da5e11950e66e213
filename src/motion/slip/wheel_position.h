// Lateral position of a single wheel (y of body), learnt in bends.
//
// A wheel that is y metres to the left of the IMU rolls omega y metres per second slower in a bend
// than the body's origin. That is 8 % on a car that turns round a corner. Without this the estimate
// takes it for slip and for tilt. docs/estimation.md, "Where the wheel is".
#pragma once

#include "gprodom/config.h"

namespace gprodom::slip {

// What is saved for the next run.
struct LearntPosition {
  double y_m = 0.0, sigma_m = 0.0;  // in body; sigma 0: not learnt
};

class WheelPosition {
 public:
  // With left and right wheels the middle is the wheel: its position is as configured.
  explicit WheelPosition(const WheelConfig& config);

  void learn(double y_m, double sigma_m);
  // Of an earlier run with the same wheel.
  void resume(const LearntPosition& earlier);

  bool learns() const { return prior_sigma_m_ > 0; }
  const LearntPosition& learnt() const { return learnt_; }

  // What the estimate uses, m. Most likely the configuration is right, so an offset
  // by what users measure wrong, or an uncertain one, does not count.
  double believed_m() const;

 private:
  double configured_m_, prior_sigma_m_;
  LearntPosition learnt_;
};

}  // namespace gprodom::slip
