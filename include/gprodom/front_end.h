// A radar front end turns traces into findings about motion. It knows nothing of states.
//
// For one of your own, derive from FrontEnd and give Odometry or Live a FrontEndFactory.
// examples/cpp/front_end is an example; docs/python.md has the same in Python. The type of a
// finding decides how the estimator uses it:
//
//   Standstill         The antenna did not move, whatever the wheel says. With a still IMU it makes
//                      a zero-velocity update. It is not a displacement of 0 m.
//   TrackDisplacement  A signed distance in metres: enters the window as a measurement.
//   PathLength         An unsigned distance in a unit of the ground, whose length is not known.
//   Sight              The slowest motion that the Standstill test can detect.
//
// `valid` false: nothing is known about that interval. The finding is published with its score, and
// not used; for the estimator it is the same as no finding. `sigma_m` is the standard deviation of
// distance_m of this finding. It is the weight against wheel and IMU: if it is too small, a wrong
// measurement pulls the pose away. The errors of consecutive findings count as independent; if they
// are correlated, raise sigma_m accordingly. In displacement_t, Standstill and PathLength have the
// kind KIND_MOTION, TrackDisplacement has KIND_SEQUENTIAL.
//
// A finding with an impossible value (not finite, sigma_m not above 0, from >= to, to after the
// tick) is dropped with a warning.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gprodom/export.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

// The antenna stood from `from` to `to`.
struct Standstill {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;    // name of the method, for displacement_t.source
  double sigma_m = 0.0;  // motion that the test may have missed
  double score = 0.0;    // defined by the method
  // The antenna is where it was at this time, which may be earlier than `from`: the traces of then
  // and now were compared and are equal. 0: they were not compared.
  TimeNs since = 0;
};

// Unsigned distance that the antenna moved, in decorrelation lengths of the ground. The front end
// does not know how long they are in metres; the estimator learns that from wheel and IMU.
struct PathLength {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;
  bool valid = false;
  double lengths = 0.0;  // above 0
  double score = 0.0;
  int unit = 0;  // lengths of another number cannot be compared with these
};

// Signed distance that the antenna moved along its track, forwards positive, in metres.
struct TrackDisplacement {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;
  bool valid = false;
  double distance_m = 0.0;
  double sigma_m = 0.0;  // standard deviation
  double score = 0.0;
};

// Detection limit of a front end that gives Standstill: from `from` to `to` the antenna moved at
// `times_least` times the slowest speed that its test can detect. The estimator learns from wheel
// and IMU how many m/s that is. A Standstill does not contradict a wheel that is slower.
struct Sight {
  TimeNs from = 0;
  TimeNs to = 0;
  double times_least = 0.0;  // above 0
};

using Finding = std::variant<Standstill, PathLength, TrackDisplacement, Sight>;

// A front end runs on one thread (the GPR thread when live) and depends on data time only: the same
// traces and ticks must give the same findings, or replays differ.
class GPRODOM_EXPORT FrontEnd {
 public:
  virtual ~FrontEnd() = default;

  // One valid trace, in time order. Must be cheap enough for several hundred traces a second.
  virtual void add_trace(const GprTrace& trace) = 0;

  // Findings at `tick`, from the traces up to it.
  virtual std::vector<Finding> tick(TimeNs tick) = 0;

  // The feature matrix of the last tick, if the front end has made one and paper.publish_sfm is
  // set.
  virtual std::optional<SubsurfaceFeatureMatrix> sfm() const { return std::nullopt; }

  // Forgets all traces (after a gap, a reset, a change of trace length or sample interval).
  virtual void reset() = 0;
};

// Makes a front end: once at the start, and again whenever the estimator restarts (a reset, a
// clock that was set). Must not return null. An exception at the start leaves the constructor of
// Odometry or Live; later it must not throw.
using FrontEndFactory = std::function<std::unique_ptr<FrontEnd>()>;

}  // namespace gprodom::gpr
