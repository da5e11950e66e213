// The pose graph as a ceres::Problem: three parameters for each node, a slip for each step, and the
// wheel's scale.
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
  // Prior of the slips.
  enum class SlipPrior {
    kUsuallyNone,  // for the solution: robust; either no slip, or one that lasts
    kGaussian      // for the covariance: of the same variance
  };

  GraphProblem(const std::vector<PlanarPose>& nodes, const std::vector<WhitenedStep>& steps,
               const std::vector<double>& slips, const Scale& scale, SlipPrior prior,
               const PoseGraphOptions& options);
  // Ceres keeps pointers into the object.
  GraphProblem(const GraphProblem&) = delete;
  GraphProblem& operator=(const GraphProblem&) = delete;

  void add_revisit(const RevisitEdge& edge, bool robust);

  // width: factor on the width of all robust kernels. Throws std::runtime_error if no solution is
  // found.
  void solve(double width);

  PlanarPose node(std::size_t i) const;
  double slip(std::size_t step) const { return slips_[step]; }
  double scale() const { return scale_; }

  // Marginal covariance of the newest node, the scale and the last slip, at the solution. Throws
  // std::runtime_error if the normal equations are singular.
  Matrix5d newest_covariance();

 private:
  void add_slip_priors(const std::vector<WhitenedStep>& steps);
  void add_gaussian_slip_priors(const std::vector<WhitenedStep>& steps);
  double* slip_of(std::size_t node, const WheelWay& way);

  PoseGraphOptions options_;
  std::vector<std::array<double, 3>> nodes_;
  std::vector<double> slips_;
  std::array<double, 3> map_ = {0.0, 0.0, 0.0};  // node of the places that are fixed in map
  std::array<double, 2> no_slip_ = {0.0, 0.0};   // slip of the places that lie on no step
  double scale_;
  double width_ = 1.0;      // the kernels point to it
  ceres::Problem problem_;  // points to all of the above
};

}  // namespace gprodom
