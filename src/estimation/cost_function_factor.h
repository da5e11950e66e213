// A user's cost function as a factor of the window.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "estimation/factors.h"
#include "gprodom/user_factor.h"

namespace gprodom {

// The reason to refuse a factor whose first moment lies before the window's oldest state.
constexpr char kOlderThanWindow[] = "older than the window (smoother.lag)";

// The reason why no window can use the factor; empty if there is none.
std::string malformed(const UserFactor& factor);

// The user's cost function, evaluated with the states at the factor's moments. The IMU propagates
// each of them from a state of the window. Its noise over less than one state interval is ignored.
class CostFunctionFactor final : public Factor {
 public:
  struct Moment {
    bool of_b = false;        // propagated from b, otherwise from a
    ImuPreintegration since;  // from that state to the moment
  };
  // factor: well-formed. moments: one for each of its times. origin: of the frame of the states, in
  // odom (Window::origin).
  CostFunctionFactor(const UserFactor& factor, std::vector<Moment> moments, double gravity_mps2,
                     std::shared_ptr<const Eigen::Vector3d> origin)
      : factor_(factor),
        moments_(std::move(moments)),
        gravity_mps2_(gravity_mps2),
        origin_(std::move(origin)) {}

  int dimension() const override { return factor_.cost->num_residuals(); }
  // The residual is NaN if the cost function fails.
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;
  // Always true, although a factor of two moments may measure only the motion between them.
  bool measures_place() const override;
  const ceres::LossFunction* loss() const override { return factor_.loss.get(); }

 private:
  UserFactor factor_;
  std::vector<Moment> moments_;
  double gravity_mps2_;
  std::shared_ptr<const Eigen::Vector3d> origin_;
};

}  // namespace gprodom
