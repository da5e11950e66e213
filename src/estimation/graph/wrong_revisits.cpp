#include "estimation/graph/wrong_revisits.h"

#include <algorithm>
#include <utility>

namespace gprodom {
namespace {

// Kernels begin so wide that the worst revisit is inside, but at most kWidest times their final
// width. From one solution to the next they become narrower by the factor kNarrower.
constexpr double kWidest = 64.0, kNarrower = 4.0;

// The largest deviation of a trusted one.
double worst_of(const std::vector<double>& deviations, const std::vector<bool>& trusted) {
  double worst = 0.0;
  for (std::size_t i = 0; i < deviations.size(); ++i)
    if (trusted[i]) worst = std::max(worst, deviations[i]);
  return worst;
}

double width_for(double worst, double drop_beyond) {
  double width = 1.0;
  while (width * drop_beyond < worst && width < kWidest) width *= kNarrower;
  return width;
}

std::vector<bool> within(double limit, const std::vector<double>& deviations) {
  std::vector<bool> result;
  for (double deviation : deviations) result.push_back(deviation <= limit);
  return result;
}

}  // namespace

bool refine(GraphProblem& problem, const std::vector<bool>& trusted,
            const PoseGraphOptions& options, GraphProblem::Unknowns& at) {
  const auto agrees = [&](const GraphProblem::Unknowns& solution) {
    const std::vector<double> deviations = problem.deviations(solution);
    for (std::size_t i = 0; i < deviations.size(); ++i) {
      if (trusted[i] && deviations[i] > options.drop_beyond) return false;
      if (!trusted[i] && deviations[i] <= options.full_weight_below) return false;
    }
    return true;
  };
  if (!agrees(at)) return false;
  GraphProblem::Unknowns refined = at;
  problem.solve({trusted, RevisitKernel::kFullWeight, 1.0}, refined);
  if (!agrees(refined)) return false;
  at = std::move(refined);
  return true;
}

// A wrong revisit increases the residuals of right ones. So the worst are removed first; right ones
// among them are restored afterwards, once. Wide kernels, which find out what is wrong among
// revisits that contradict each other, lead far from the last solution and back. That is not
// repeated for a contradiction that is settled.
std::vector<bool> drop_wrong(GraphProblem& problem, std::vector<bool> trusted,
                             const PoseGraphOptions& options, GraphProblem::Unknowns& at) {
  const GraphProblem::Unknowns start = at;
  const std::vector<double> at_start = problem.deviations(start);
  bool tries_all = std::find(trusted.begin(), trusted.end(), false) == trusted.end();
  double width = width_for(worst_of(at_start, trusted), options.drop_beyond);
  for (bool restored = false;;) {
    for (; width > 1.0; width /= kNarrower)
      problem.solve({trusted, RevisitKernel::kRedescending, width}, at);
    problem.solve({trusted, RevisitKernel::kRedescending, 1.0}, at);
    const std::vector<double> deviations = problem.deviations(at);
    const double worst = worst_of(deviations, trusted);
    std::vector<bool> agree = within(options.drop_beyond, deviations);
    if (worst > options.drop_beyond && !tries_all && !restored) {
      tries_all = true;
      trusted.assign(trusted.size(), true);
      width = width_for(worst_of(at_start, trusted), options.drop_beyond);
      at = start;
    } else if (worst > options.drop_beyond) {
      for (std::size_t i = 0; i < deviations.size(); ++i)
        trusted[i] = trusted[i] && deviations[i] <= std::max(options.drop_beyond, 0.5 * worst);
    } else if (!restored && agree != trusted) {
      restored = true;
      trusted = std::move(agree);
    } else {
      break;
    }
  }
  problem.solve({trusted, RevisitKernel::kFullWeight, 1.0}, at);
  return trusted;
}

}  // namespace gprodom
