// Derivatives by differences, for what is differentiated by hand.
#pragma once

#include <Eigen/Core>

namespace gprodom {

// Of a vector f(d) of n coordinates at d = 0: central differences of fourth order.
template <class F>
Eigen::MatrixXd numeric_jacobian(Eigen::Index n, double h, const F& f) {
  Eigen::MatrixXd J(Eigen::VectorXd(f(Eigen::VectorXd(Eigen::VectorXd::Zero(n)))).size(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto at = [&](double x) -> Eigen::VectorXd {
      return f(Eigen::VectorXd(x * Eigen::VectorXd::Unit(n, k)));
    };
    J.col(k) = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
  }
  return J;
}

}  // namespace gprodom
