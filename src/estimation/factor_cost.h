// The estimator's factors and prior as cost functions for Ceres, in the window and in the batch.
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "estimation/factors.h"
#include "estimation/marginal_prior.h"

namespace gprodom {

// Adds a factor between two states (StateManifold). Each row with a loss of its own becomes a
// residual block; the other rows form one block. robust: with losses. The problem must own its
// functions.
std::vector<ceres::ResidualBlockId> add_to(ceres::Problem& problem,
                                           const std::shared_ptr<const Factor>& factor, double* a,
                                           double* b, bool robust = true);

// A fix with its lasting error g, in its standard deviations: of the variance the share `white` is
// white, and g goes on from that of another fix (null: there is none), kept is their correlation.
struct FixErrorTerms {
  double white = 1.0, kept = 0.0;
};
struct FixBlocks {
  double *a, *b;                     // states
  double *lasting, *lasting_before;  // 2
};
void add_to(ceres::Problem& problem, const FixFactor& fix, const FixErrorTerms& error,
            const FixBlocks& blocks);

// The way that a wheel has counted over states in a row (rolled_way.h); contact: m, in body.
struct CountedTerm {
  Eigen::Vector3d contact;
  double counted_m, sigma_m;
};
void add_to(ceres::Problem& problem, const CountedTerm& counted,
            const std::vector<double*>& states);

// states: those of the prior, oldest first. Between evaluations the prior may change, except for
// its size.
ceres::ResidualBlockId add_to(ceres::Problem& problem, std::shared_ptr<const MarginalPrior> prior,
                              const std::vector<double*>& states);

}  // namespace gprodom
