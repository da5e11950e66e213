// The pose graph as Ceres sees it: three parameters a node, a slip a step, and the wheel's scale.
#pragma once

#include <ceres/ceres.h>

#include <array>
#include <vector>

#include "estimation/graph/pose_graph.h"

namespace gprodom {

class GraphProblem {
 public:
  struct Scale {
    double initial, prior, prior_sigma;  // sigma 0: held
  };
  // What is asked of the slips.
  enum class SlipPrior {
    kUsuallyNone,  // for the solution: none, or one that is held
    kGaussian      // for the covariance: the same variance, whether it slips or not
  };

  GraphProblem(const std::vector<PlanarPose>& nodes, const std::vector<WhitenedStep>& steps,
               const std::vector<double>& slips, const Scale& scale, SlipPrior prior,
               const PoseGraphOptions& options);
  // Ceres points into it.
  GraphProblem(const GraphProblem&) = delete;
  GraphProblem& operator=(const GraphProblem&) = delete;

  void add_revisit(const RevisitEdge& edge, bool robust);

  // All robust kernels `width` times as wide as they are. Throws std::runtime_error where no
  // solution is found.
  void solve(double width);

  PlanarPose node(std::size_t i) const;
  double slip(std::size_t step) const { return slips_[step]; }
  double scale() const { return scale_; }

  // Of the newest node, the scale and the last slip, from the normal equations at the solution with
  // all else eliminated. Throws std::runtime_error where they are singular.
  Matrix5d newest_covariance();

 private:
  void add_slip_priors(const std::vector<WhitenedStep>& steps);
  void add_gaussian_slip_priors(const std::vector<WhitenedStep>& steps);
  double* slip_of(std::size_t node, const WheelWay& way);

  PoseGraphOptions options_;
  std::vector<std::array<double, 3>> nodes_;
  std::vector<double> slips_;
  std::array<double, 3> map_ = {0.0, 0.0, 0.0};  // as the node of places fixed in it
  std::array<double, 2> no_slip_ = {0.0, 0.0};   // as the slips of places that are on no step
  double scale_;
  double width_ = 1.0;      // of the kernels, which point to it
  ceres::Problem problem_;  // points into all of the above
};

}  // namespace gprodom
