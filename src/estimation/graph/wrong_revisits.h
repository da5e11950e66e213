// Which revisits are wrong, and the solution without them.
#pragma once

#include <vector>

#include "estimation/graph/graph_problem.h"

namespace gprodom {

// Goes on from `at`, the last solution, where no trusted revisit contradicts it, and none that is
// left out agrees so well that it would have its full weight. Returns false, and leaves `at` as it
// was, where that is not so, there or at the solution. Throws std::runtime_error if no solution is
// found.
bool refine(GraphProblem& problem, const std::vector<bool>& trusted,
            const PoseGraphOptions& options, GraphProblem::Unknowns& at);

// Solves with redescending kernels, removes what contradicts, and solves with full weights. Returns
// which revisits are trusted. `at`, `trusted`: of the last solution, with new revisits as trusted.
// What that left out stays out as long as it contradicts, unless the others contradict each other
// without it. Throws std::runtime_error if no solution is found.
std::vector<bool> drop_wrong(GraphProblem& problem, std::vector<bool> trusted,
                             const PoseGraphOptions& options, GraphProblem::Unknowns& at);

}  // namespace gprodom
