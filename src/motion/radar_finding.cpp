#include "motion/radar_finding.h"

namespace gprodom {

namespace {

// Fills in what all findings have.
template <class Finding>
Displacement begin(const Finding& finding, DisplacementKind kind) {
  Displacement d;
  d.from = finding.from;
  d.to = finding.to;
  d.source = finding.source;
  d.kind = kind;
  d.score = finding.score;
  return d;
}

}  // namespace

Displacement to_displacement(const gpr::Standstill& standstill) {
  Displacement d = begin(standstill, DisplacementKind::kMotion);
  d.valid = true;
  d.sigma_m = standstill.sigma_m;
  return d;
}

Displacement to_displacement(const gpr::PathLength& path, double metres_per_length) {
  Displacement d = begin(path, DisplacementKind::kMotion);
  d.valid = path.valid;
  d.scale = metres_per_length;
  d.distance_m = path.lengths * metres_per_length;
  return d;
}

Displacement to_displacement(const gpr::TrackDisplacement& measured) {
  Displacement d = begin(measured, DisplacementKind::kSequential);
  d.valid = measured.valid;
  d.distance_m = measured.distance_m;
  d.sigma_m = measured.sigma_m;
  return d;
}

}  // namespace gprodom
