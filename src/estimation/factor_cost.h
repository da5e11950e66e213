// The estimator's factors and prior as Ceres' cost functions: of the window and of a whole run.
#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "estimation/factors.h"
#include "estimation/marginal_prior.h"

namespace gprodom {

// A factor between two states (StateManifold): rows with a loss of their own are a residual block
// each, the others are one together. robust: with losses. The problem must own its functions.
std::vector<ceres::ResidualBlockId> add_to(ceres::Problem& problem,
                                           const std::shared_ptr<const Factor>& factor, double* a,
                                           double* b, bool robust = true);

// `states`: of the prior, oldest first. Between evaluations the prior may change in all but size.
ceres::ResidualBlockId add_to(ceres::Problem& problem, std::shared_ptr<const MarginalPrior> prior,
                              const std::vector<double*>& states);

}  // namespace gprodom
