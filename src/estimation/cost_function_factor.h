// A user's cost function as a factor of the window.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "estimation/factors.h"
#include "gprodom/user_factor.h"

namespace gprodom {

// Why a factor is refused whose first moment lies before the window's oldest state.
constexpr char kOlderThanWindow[] = "older than the window (smoother.lag)";

// Why a factor can be used in no window at all; empty: it can.
std::string malformed(const UserFactor& factor);

// The cost function of the states at the factor's moments, each carried there from a state of the
// window by the IMU; over less than a state's interval its noise does not count.
class CostFunctionFactor final : public Factor {
 public:
  struct Moment {
    bool of_b = false;        // carried from b; else from a
    ImuPreintegration since;  // the state, up to the moment
  };
  // A factor that is not malformed, and as many moments as it has times. `origin`: of the states'
  // frame in odom, at any time (Window::origin).
  CostFunctionFactor(const UserFactor& factor, std::vector<Moment> moments, double gravity_mps2,
                     std::shared_ptr<const Eigen::Vector3d> origin)
      : factor_(factor),
        moments_(std::move(moments)),
        gravity_mps2_(gravity_mps2),
        origin_(std::move(origin)) {}

  int dimension() const override { return factor_.cost->num_residuals(); }
  // The residual is NaN where the cost function fails.
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;
  // Of two moments it may measure only how the robot moved between them; that is not looked into.
  bool measures_place() const override;
  const ceres::LossFunction* loss() const override { return factor_.loss.get(); }

 private:
  UserFactor factor_;
  std::vector<Moment> moments_;
  double gravity_mps2_;
  std::shared_ptr<const Eigen::Vector3d> origin_;
};

}  // namespace gprodom
