// Residuals and robust kernels of the prior on the slips of the pose graph's steps. slip_model.h
// has the quantities, docs/estimation.md ("Slip of a step") the derivation.
#pragma once

#include <ceres/ceres.h>

#include <cmath>

namespace gprodom {

// weight l, for one slip l.
class SlipFactor final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit SlipFactor(double weight) : weight_(weight) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * x[0][0];
    if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
    return true;
  }

 private:
  double weight_;
};

// weight (l_b - kept l_a), for the slips of two steps in a row.
class SlipChangeFactor final : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  SlipChangeFactor(double kept, double weight) : kept_(kept), weight_(weight) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (x[1][0] - kept_ * x[0][0]);
    if (!jacobians) return true;
    if (jacobians[0]) jacobians[0][0] = -weight_ * kept_;
    if (jacobians[1]) jacobians[1][0] = weight_;
    return true;
  }

 private:
  double kept_, weight_;
};

// Cauchy's kernel, rho(s) = c^2 log(1 + s / c^2), with c = threshold * width. The width belongs to
// the problem (graduated non-convexity): it begins large, where the problem is convex, and ends at
// 1.
class WideCauchyLoss final : public ceres::LossFunction {
 public:
  WideCauchyLoss(double threshold, const double& width) : threshold_(threshold), width_(width) {}
  void Evaluate(double s, double rho[3]) const override {
    const double c2 = std::pow(threshold_ * width_, 2), sum = 1 + s / c2;
    rho[0] = c2 * std::log(sum);
    rho[1] = 1 / sum;
    rho[2] = -rho[1] * rho[1] / c2;
  }

 private:
  double threshold_;
  const double& width_;
};

// Geman and McClure's kernel, rho(s) = s / (1 + s / c^2): an outlier costs at most c^2.
class WideGemanMcClureLoss final : public ceres::LossFunction {
 public:
  WideGemanMcClureLoss(double threshold, const double& width)
      : threshold_(threshold), width_(width) {}
  void Evaluate(double s, double rho[3]) const override {
    const double c2 = std::pow(threshold_ * width_, 2), sum = 1 + s / c2;
    rho[0] = s / sum;
    rho[1] = 1 / (sum * sum);
    rho[2] = -2 / (c2 * sum * sum * sum);
  }

 private:
  double threshold_;
  const double& width_;
};

}  // namespace gprodom
