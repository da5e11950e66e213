#include "estimation/cost_function_factor.h"

#include <algorithm>
#include <limits>

#include "estimation/predict.h"
#include "estimation/state_manifold.h"

namespace gprodom {

namespace {

struct Place {
  int offset, size;
};

// Of a part among the parameters of a state; in the order of StatePart.
Place place_of(StatePart part) {
  constexpr std::array<Place, 6> kPlaces{{{ambient::kQ, 4},
                                          {ambient::kP, 3},
                                          {ambient::kV, 3},
                                          {ambient::kBg, 3},
                                          {ambient::kBa, 3},
                                          {ambient::kScale, 1}}};
  static_assert(int(StatePart::kWheelScale) + 1 == kPlaces.size());
  return kPlaces[static_cast<std::size_t>(part)];
}

}  // namespace

std::string malformed(const UserFactor& factor) {
  if (!factor.cost) return "no cost function";
  if (factor.times.empty() || factor.times.size() > 2) return "expected one moment or two";
  if (factor.times.front() > factor.times.back()) return "the later moment is first";
  const int rows = factor.cost->num_residuals();
  if (rows < 1 || rows > kMaxResidual)
    return "expected 1 to " + std::to_string(kMaxResidual) + " residuals, got " +
           std::to_string(rows);
  const std::vector<int>& sizes = factor.cost->parameter_block_sizes();
  if (sizes.empty() || sizes.size() != factor.blocks.size())
    return "expected a part of the state for each parameter block of the cost function";
  for (size_t i = 0; i < sizes.size(); ++i) {
    if (factor.blocks[i].moment >= factor.times.size())
      return "block " + std::to_string(i) + ": no such moment";
    const int size = place_of(factor.blocks[i].part).size;
    if (size != sizes[i])
      return "block " + std::to_string(i) + ": the part has " + std::to_string(size) +
             " values, the cost function expects " + std::to_string(sizes[i]);
  }
  return "";
}

bool CostFunctionFactor::measures_place() const {
  return std::any_of(factor_.blocks.begin(), factor_.blocks.end(), [](const auto& block) {
    return block.part == StatePart::kAttitude || block.part == StatePart::kPosition ||
           block.part == StatePart::kVelocity;
  });
}

void CostFunctionFactor::evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                                  Jacobian* Jb) const {
  std::array<NavState, 2> states;
  std::array<StateParameters, 2> values;
  for (size_t k = 0; k < moments_.size(); ++k) {
    states[k] = propagate(moments_[k].of_b ? b : a, moments_[k].since, gravity_mps2_);
    to_parameters(states[k], values[k].data());
    Eigen::Map<Eigen::Vector3d>{values[k].data() + ambient::kP} += *origin_;
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<const double*> parameters;
  std::vector<Rows> derivatives;
  std::vector<double*> jacobians;
  for (const UserFactor::Block& block : factor_.blocks) {
    const auto [offset, size] = place_of(block.part);
    parameters.push_back(values[block.moment].data() + offset);
    derivatives.emplace_back(dimension(), size);
    jacobians.push_back(derivatives.back().data());
  }
  r.resize(dimension());
  if (!factor_.cost->Evaluate(parameters.data(), r.data(), Ja ? jacobians.data() : nullptr))
    r.setConstant(std::numeric_limits<double>::quiet_NaN());
  if (!Ja) return;

  Ja->setZero(dimension(), kStateDim);
  Jb->setZero(dimension(), kStateDim);
  for (size_t k = 0; k < moments_.size(); ++k) {
    const bool of_b = moments_[k].of_b;
    const ParameterJacobian by_state = parameter_jacobian(
        states[k], propagation_jacobian(of_b ? b : a, moments_[k].since, gravity_mps2_));
    for (size_t i = 0; i < factor_.blocks.size(); ++i) {
      if (factor_.blocks[i].moment != k) continue;
      const auto [offset, size] = place_of(factor_.blocks[i].part);
      *(of_b ? Jb : Ja) += derivatives[i] * by_state.middleRows(offset, size);
    }
  }
}

}  // namespace gprodom
