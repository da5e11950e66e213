// A radar front end: traces in, findings about motion out. It knows nothing of states.
//
// To bring one of your own, derive from FrontEnd and give Odometry or Live a FrontEndFactory;
// examples/cpp/front_end is one, docs/python.md has the same in Python. What a finding says decides
// how the estimator uses it:
//
//   Standstill         Both the wheel and the IMU may drift or slip: this says that the antenna did
//                      not move at all. With a still IMU it makes a zero-velocity update. It is not
//                      a displacement of 0 m.
//   TrackDisplacement  How far, in metres, with a sign: enters the window as a measurement.
//   PathLength         How far, in a unit that the ground defines and nobody knows in advance.
//   Sight              How slow a motion the Standstill test can see.
//
// `valid` false: nothing can be said of that interval. It is published, with its score, and not
// used; leaving the finding out is the same to the estimator. `sigma_m` is the standard deviation
// of distance_m for this one finding: a displacement is weighted by it against wheel and IMU, and
// one that is too small draws the pose to a wrong measurement. Errors of findings that follow each
// other count as independent: where they are not, raise sigma_m accordingly. In displacement_t,
// Standstill and PathLength are of kind KIND_MOTION, TrackDisplacement of KIND_SEQUENTIAL.
//
// A finding with a value that cannot be (not finite, sigma_m not above 0, from >= to, to after the
// tick) is dropped, and a warning tells so.
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
  std::string source;    // the method that says so, for displacement_t.source
  double sigma_m = 0.0;  // motion that may have passed unseen
  double score = 0.0;    // of the method's own
};

// How far the antenna moved, whichever way, in decorrelation lengths of the ground: the front end
// does not know how many metres one of them is. The estimator learns that from wheel and IMU.
struct PathLength {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;
  bool valid = false;
  double lengths = 0.0;  // above 0
  double score = 0.0;
};

// How far the antenna moved along its track, forwards positive, in metres.
struct TrackDisplacement {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;
  bool valid = false;
  double distance_m = 0.0;
  double sigma_m = 0.0;  // standard deviation
  double score = 0.0;
};

// How well a front end that tells Standstill sees motion: from `from` to `to` the antenna moved at
// `times_least` times the slowest speed that its test sees. How many m/s that is, the estimator
// learns from wheel and IMU; a wheel that turns slower is not contradicted by a Standstill.
struct Sight {
  TimeNs from = 0;
  TimeNs to = 0;
  double times_least = 0.0;  // above 0
};

using Finding = std::variant<Standstill, PathLength, TrackDisplacement, Sight>;

// Front ends run on one thread (the GPR thread when live) and are driven by data time alone: for
// replays to be alike, the same traces and ticks must give the same findings, whatever the clock
// says.
class GPRODOM_EXPORT FrontEnd {
 public:
  virtual ~FrontEnd() = default;

  // One valid trace, in time order. Must be cheap enough for several hundred traces a second.
  virtual void add_trace(const GprTrace& trace) = 0;

  // What can be said at `tick`, given the traces up to it.
  virtual std::vector<Finding> tick(TimeNs tick) = 0;

  // The feature matrix made at the last tick, where the front end makes them, made one then and is
  // asked for them (paper.publish_sfm).
  virtual std::optional<SubsurfaceFeatureMatrix> sfm() const { return std::nullopt; }

  // Forgets all traces (after a gap, a reset, a change of trace length or sample interval).
  virtual void reset() = 0;
};

// Makes a front end: once at the start, and again whenever the estimator starts afresh (a reset, a
// clock that was set). Must not return null. What it throws at the start comes out of the
// constructor of Odometry or Live; it must not throw later.
using FrontEndFactory = std::function<std::unique_ptr<FrontEnd>()>;

}  // namespace gprodom::gpr
