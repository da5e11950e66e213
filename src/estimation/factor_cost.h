// The estimator's factors and prior as cost functions for Ceres, in the window and in the batch.
#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "estimation/batch.h"

namespace gprodom {

// Adds a factor between two states (StateManifold). Each row with a loss of its own becomes a
// residual block; the other rows form one block. robust: with losses. The problem must own its
// functions.
std::vector<ceres::ResidualBlockId> add_to(ceres::Problem& problem,
                                           const std::shared_ptr<const Factor>& factor, double* a,
                                           double* b, bool robust = true);

// A fix with its lasting error, in its standard deviations, that of the fix before it (null: there
// is none), and its antenna.
struct FixBlocks {
  double *a, *b;                     // states
  double *lasting, *lasting_before;  // 2
  double* antenna;                   // 3, as FixFactor has them
};
void add_to(ceres::Problem& problem, const Batch::Fix& fix, const FixBlocks& blocks);
void add_to(ceres::Problem& problem, const Batch::Antenna& prior, double* antenna);

// states: all from the one to the other end of the way.
void add_to(ceres::Problem& problem, const Batch::Way& counted, const std::vector<double*>& states);

// states: those of the prior, oldest first. Between evaluations the prior may change, except for
// its size.
ceres::ResidualBlockId add_to(ceres::Problem& problem, std::shared_ptr<const MarginalPrior> prior,
                              const std::vector<double*>& states);

}  // namespace gprodom
