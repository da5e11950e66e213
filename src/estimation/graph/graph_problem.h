// The least squares of the pose graph: three unknowns for each node, a slip for each step, and the
// wheel's scale. Gauss-Newton with Levenberg's and Marquardt's damping where a step fails.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "estimation/graph/normal_matrix.h"
#include "estimation/graph/planar_factors.h"
#include "estimation/graph/pose_graph.h"
#include "estimation/graph/robust_kernels.h"

namespace gprodom {

// How a revisit's weight falls with its residual.
enum class RevisitKernel {
  kRedescending,  // Cauchy: one that is far off hardly counts
  kFullWeight     // Huber: full for 95 % of right ones, and beyond never more than theirs
};

class GraphProblem {
 public:
  struct Unknowns {
    std::vector<PlanarPose> nodes;
    std::vector<double> slips;  // of the steps
    double scale;
    std::vector<Eigen::Vector2d> lasting;  // errors of the fixes, in standard deviations
  };
  struct ScalePrior {
    double scale, sigma;  // sigma 0: held
  };
  struct Priors {
    ScalePrior scale;
    std::optional<FirstPrior> first;
  };
  // Which revisits count, with which kernel, and a factor on the width of all redescending kernels.
  struct Terms {
    const std::vector<bool>& trusted;
    RevisitKernel kernel;
    double width;
  };

  // The problem refers to steps, revisits and fixes.
  GraphProblem(const std::vector<WhitenedStep>& steps, const std::vector<RevisitEdge>& revisits,
               const std::vector<FixEdge>& fixes, const Priors& priors,
               const PoseGraphOptions& options);

  // Throws std::runtime_error if no solution is found.
  void solve(const Terms& terms, Unknowns& at);

  // Marginal covariance of the newest node, the scale and the last slip, at a solution. Throws
  // std::runtime_error if the normal equations are singular.
  Matrix5d newest_covariance(const std::vector<bool>& trusted, const Unknowns& at);

  // Of each revisit, in standard deviations: the norm of its residual.
  std::vector<double> deviations(const Unknowns& at) const;

  double work() const { return equations_.work(); }  // of all of that, so far
  int iterations() const { return iterations_; }     // of all solve() so far

 private:
  enum class SlipPrior {
    kUsuallyNone,  // for the solution: robust; either no slip, or one that lasts
    kGaussian      // for the covariance: of the same variance
  };
  // Constants of the priors on the slip of a step.
  struct SlipTerms {
    bool possible = false, follows = false;  // follows: the step before may slip too
    double none = 0.0, most = 0.0;           // weight of "no slip", and its kernel's threshold
    double size = 0.0, change = 0.0;         // weights
    double kept = 0.0, gaussian = 0.0;       // of the Gaussian prior
  };
  SlipTerms slip_terms(std::size_t step) const;

  int node(std::size_t i) const { return static_cast<int>(4 * i); }  // number of its first unknown
  int slip(std::size_t step) const { return node(step) + 3; }
  int scale() const { return slip(steps_.size()); }
  int lasting(std::size_t fix) const { return scale() + 1 + static_cast<int>(2 * fix); }
  std::size_t slip_step(std::size_t node, const WheelWay& way) const;
  // Of a revisit: the steps on which its ends lie; their number where an end lies on none.
  struct RevisitAt {
    PlanarResidual residual;
    std::size_t memory_step, query_step;
  };
  RevisitAt revisit_at(const RevisitEdge& edge, const Unknowns& at) const;

  // Half the sum of the squares, and its normal equations.
  double linearise(const Terms& terms, SlipPrior prior, const Unknowns& at);
  double add_slip_priors(SlipPrior prior, double width, const std::vector<double>& slips);
  void add_slip_prior(std::size_t step, const std::vector<double>& slips, double weight,
                      double kept, double weight_of_change);
  Robust kernel_of(double s, const Terms& terms) const;
  double add_revisit(const RevisitEdge& edge, bool counts, const Terms& terms, const Unknowns& at);
  double add_fix(std::size_t number, const Terms& terms, const Unknowns& at);
  double add_lasting(std::size_t number, const Unknowns& at);
  double add_first(bool tied, const PlanarPose& at);
  Unknowns moved(const Unknowns& at, const Eigen::VectorXd& step) const;

  const std::vector<WhitenedStep>& steps_;
  const std::vector<RevisitEdge>& revisits_;
  const std::vector<FixEdge>& fixes_;
  Priors priors_;
  PoseGraphOptions options_;
  std::vector<SlipTerms> slip_terms_;
  NormalMatrix equations_;
  bool first_held_ = true;  // the first node, in the last linearisation
  int iterations_ = 0;
};

}  // namespace gprodom
