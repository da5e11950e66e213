// Salient regions of a B-scan: the apexes of hyperbolas, as pipes, bars and stones draw them
// (Skartados et al. 2019 match such regions against a model of the ground).
//
// A reflector at column c0 whose echo takes t0 there has in column c the two-way travel time
//
//   t(c)^2 = t0^2 + (w (c - c0))^2,   w = 2 spacing / wave speed,   in seconds per column.
//
// So shape and spacing together give the wave speed and the permittivity; traces alone, whose
// spacing is not known, give w only.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gprodom::gpr {

struct Apex {
  double column = 0.0;      // c0, with its fraction
  double time_s = 0.0;      // t0, from time zero to the middle of the echo
  double widening_s = 0.0;  // w, seconds per column
  double amplitude = 0.0;   // largest of the mean echo along the hyperbola, unit of the B-scan
  double semblance = 0.0;   // stacked energy over energy, 0 to 1
};

struct ApexOptions {
  double sample_interval_s = 0.0;
  double time_zero_s = 0.0;    // from the first sample to the surface
  double first_time_s = 2e-9;  // after time zero; before is the direct wave
  double pulse_s = 3e-9;       // length of an echo
  // Widenings that are looked for, seconds per column; 0: from a hyperbola of 4 columns either side
  // to one as wide as the B-scan.
  double least_widening_s = 0.0;
  double most_widening_s = 0.0;
};

// The semblance that random ground exceeds with probability `chance`. With energy in two
// quadratures and n independent columns, P(S > s) = (1 - s)^(n - 1). Columns are not independent;
// `median`, of the semblance over the whole B-scan, tells n.
double semblance_threshold(double median, double chance);

// Apexes in bscan (samples x columns, background removed), the strongest first. Each is a maximum
// over column, time and widening of the energy that the mean echo along its hyperbola explains; the
// maximum lies inside the range of widenings, so a layer is none; and random ground has such a
// semblance in one B-scan of a hundred. Of several on one hyperbola the strongest is kept.
// Its place, time and widening are refined by least squares: one wavelet along the hyperbola, of a
// strength for each column.
// Throws std::invalid_argument if the sample interval or the pulse is not positive.
std::vector<Apex> find_apexes(const Eigen::MatrixXf& bscan, const ApexOptions& options);

}  // namespace gprodom::gpr
