// Robust kernels rho(s) of a squared residual s, with their derivative: the weight of the residual
// in iteratively reweighted least squares. Their width belongs to the problem (graduated
// non-convexity): it begins large, where the problem is convex, and ends at 1.
#pragma once

#include <cmath>

namespace gprodom {

struct Robust {
  double cost, weight;
};

// Cauchy: c^2 log(1 + s / c^2).
inline Robust cauchy(double s, double c) {
  const double c2 = c * c, sum = 1 + s / c2;
  return {c2 * std::log(sum), 1 / sum};
}

// Huber: s up to c^2, and the root beyond.
inline Robust huber(double s, double c) {
  if (s <= c * c) return {s, 1.0};
  const double root = std::sqrt(s);
  return {2 * c * root - c * c, c / root};
}

// Geman and McClure: s / (1 + s / c^2); an outlier costs at most c^2.
inline Robust geman_mcclure(double s, double c) {
  const double sum = 1 + s / (c * c);
  return {s / sum, 1 / (sum * sum)};
}

}  // namespace gprodom
