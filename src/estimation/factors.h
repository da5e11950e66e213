// Residuals between states, each with analytic Jacobians in the chart of nav_state.h.
//
// Every factor returns its residual whitened (unit variance per row). Its comment gives residual,
// order, units and weighting; docs/estimation.md has the derivations.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "estimation/increments/imu_preintegration.h"
#include "estimation/increments/wheel_increment.h"
#include "estimation/nav_state.h"
#include "estimation/planar_geometry.h"

namespace ceres {
class LossFunction;
}

namespace gprodom {

constexpr int kMaxResidual = 9;
using Residual = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxResidual, 1>;
using Jacobian =
    Eigen::Matrix<double, Eigen::Dynamic, kStateDim, Eigen::RowMajor, kMaxResidual, kStateDim>;

// A constraint between an earlier state a and a later state b.
class Factor {
 public:
  virtual ~Factor() = default;
  virtual int dimension() const = 0;
  // Ja and Jb may be null (both): then no Jacobians are computed.
  virtual void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                        Jacobian* Jb) const = 0;
  // Cauchy threshold of a row in standard deviations: weight 1 / (1 + (r / threshold)^2). 0: the
  // row is quadratic.
  virtual double robust_threshold(int /*row*/) const { return 0.0; }
  // The same factor with the wheel's distance multiplied by e^l; null if it does not use the wheel.
  virtual std::shared_ptr<const Factor> with_slip(double /*l*/) const { return nullptr; }
  // The same factor with another standard deviation of the scale's step; null if it has none.
  virtual std::shared_ptr<const Factor> with_scale_step(double /*sigma*/) const { return nullptr; }
  // Whether it measures the position in odom or the heading, which the robot's own sensors do not.
  virtual bool measures_place() const { return false; }
  // Replaces the thresholds: a loss on the squared norm of all rows; null: none.
  virtual const ceres::LossFunction* loss() const { return nullptr; }
};

// Half the sum of the squared residuals, under the factor's losses.
double robust_cost(const Factor& factor, const Residual& r);

// Scales the rows by the square root of their robust weights. The remaining problem is quadratic.
void weight_rows(const Factor& factor, Residual& r, Jacobian& Ja, Jacobian& Jb);

// [Log(dq^-1 q_a^-1 q_b); R_a^T (v_b - v_a - g dt) - dv; R_a^T (p_b - p_a - v_a dt - g dt^2/2) -
// dp] rad, m/s, m; whitened by the preintegrated covariance. Forster et al. 2017, eq. 45.
class ImuFactor final : public Factor {
 public:
  // gravity_odom: m/s^2, pointing down. Throws std::invalid_argument if the covariance is singular
  // (no duration).
  ImuFactor(const ImuPreintegration& preintegration, const Eigen::Vector3d& gravity_odom);
  int dimension() const override { return 9; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;

 private:
  ImuPreintegration preintegration_;
  Eigen::Vector3d gravity_odom_;
  Matrix9d whitening_;
};

// [bg_b - bg_a; ba_b - ba_a; s_b - s_a]; rad/s, m/s^2, 1; sigmas over the interval, above 0.
class RandomWalkFactor final : public Factor {
 public:
  RandomWalkFactor(double gyro_bias_sigma, double accel_bias_sigma, double scale_sigma);
  int dimension() const override { return 7; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;
  std::shared_ptr<const Factor> with_scale_step(double sigma) const override;

 private:
  Eigen::Matrix<double, 7, 1> weight_;
};

// Estimate of a wheel's slip in an interval, l = ln(true distance / distance by the wheel).
struct WheelSlipTerm {
  double l = 0.0, sigma = 0.0;
};

// Lateral position of a single wheel in body, as bends have shown it up to now.
struct WheelPlaceTerm {
  double y_m = 0.0;
};

// U (R_a^T (c_b - c_a) - e^l dp(bg) / s) with c = p + R lever_arm: forward, lateral, vertical,
// metres, with dp the wheel's increments rotated by the gyro. U = diag(s, 1, 1), since the wheel's
// error is on the distance that it reports, and side slip on the true one. The last two rows are
// the non-holonomic constraint (Wu et al. 2017). The forward row is robust (Cauchy), since wheels
// slip forwards.
class WheelFactor final : public Factor {
 public:
  // variance: forward, lateral, vertical, m^2; the variance of l is added to the forward one.
  // robust_threshold: standard deviations; 0: quadratic. Read at each evaluation: slip (null:
  // none), and place (null: that of the lever arm).
  WheelFactor(const WheelIncrement& increment, const Eigen::Vector3d& lever_arm,
              const Eigen::Vector3d& variance, double robust_threshold,
              std::shared_ptr<const WheelSlipTerm> slip = nullptr,
              std::shared_ptr<const WheelPlaceTerm> place = nullptr);
  int dimension() const override { return 3; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;
  double robust_threshold(int row) const override { return row == 0 ? robust_threshold_ : 0.0; }
  std::shared_ptr<const Factor> with_slip(double l) const override;

 private:
  WheelIncrement increment_;
  Eigen::Vector3d lever_arm_;
  double robust_threshold_;
  Eigen::Vector3d variance_;
  std::shared_ptr<const WheelSlipTerm> slip_;
  std::shared_ptr<const WheelPlaceTerm> place_;
};

// |c_b - c_a| - |d| / s, metres: the paper's wheel term, which has no sign. The norm is smoothed
// below 0.1 mm, since it has no derivative at 0.
class WheelDistanceFactor final : public Factor {
 public:
  WheelDistanceFactor(double distance_m, double sigma_m, const Eigen::Vector3d& lever_arm,
                      double robust_threshold);
  int dimension() const override { return 1; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;
  double robust_threshold(int /*row*/) const override { return robust_threshold_; }

 private:
  double distance_m_, sigma_m_;
  Eigen::Vector3d lever_arm_;
  double robust_threshold_;
};

// How far a standing robot moves between two states, as it sways and settles on its tyres.
struct StandstillSigmas {
  double rotation = 1e-5;  // rad
  double position = 1e-4;  // m
  double velocity = 2e-3;  // m/s
};

// [Log(q_a^-1 q_b); R_a^T (p_b - p_a); R_b^T v_b]; rad, m, m/s: the robot stood from a to b.
// In body axes, so that it does not observe the global position or heading.
class StandstillFactor final : public Factor {
 public:
  explicit StandstillFactor(const StandstillSigmas& sigmas) : sigmas_(sigmas) {}
  int dimension() const override { return 9; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;

 private:
  StandstillSigmas sigmas_;
};

// e1^T (R_b^T v_b - R_a^T v_a), m/s: the speed forwards is a random walk, with a robust row
// (Cauchy, at one sigma), since a robot brakes now and then. sigma: over the interval, above 0.
class SpeedWalkFactor final : public Factor {
 public:
  explicit SpeedWalkFactor(double sigma) : sigma_(sigma) {}
  int dimension() const override { return 1; }
  double robust_threshold(int /*row*/) const override { return 1.0; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;

 private:
  double sigma_;
};

// Along-track displacement from the radar, metres, one row. Measured from time a + offset_a to
// b + offset_b; the states' velocities bridge the offsets (fractions of a state interval).
// signed:  e1^T R_a^T (c_b - c_a) - d;   norm (the paper's):  |c_b - c_a| - |d|.
class DisplacementFactor final : public Factor {
 public:
  enum class Form { kSigned, kNorm };
  struct Measurement {
    double distance_m = 0, sigma_m = 1;
    double offset_a_s = 0, offset_b_s = 0;
    Form form = Form::kSigned;
    double robust_threshold = 0;
  };
  DisplacementFactor(const Measurement& measurement, const Eigen::Vector3d& lever_arm)
      : DisplacementFactor(measurement, lever_arm, lever_arm) {}
  // From one point of the body at a to another at b: two antennas that pass the same place.
  DisplacementFactor(const Measurement& measurement, const Eigen::Vector3d& lever_arm_a,
                     const Eigen::Vector3d& lever_arm_b)
      : measurement_(measurement), lever_arm_a_(lever_arm_a), lever_arm_b_(lever_arm_b) {}
  int dimension() const override { return 1; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;
  double robust_threshold(int /*row*/) const override { return measurement_.robust_threshold; }

 private:
  Measurement measurement_;
  Eigen::Vector3d lever_arm_a_, lever_arm_b_;
};

// Revisit (loop closure): the antenna at b is above ground that it saw at a. With c = p + R (place,
// 0) and Q = R_a Rz(yaw of the memory's place):
//   [e1^T Q^T (c_b - c_a) - offset; e2^T Q^T (c_b - c_a) - lateral], m.
// The first row is robust (Cauchy).
class RevisitFactor final : public Factor {
 public:
  // The edge's places are in the frames of a and b.
  explicit RevisitFactor(const RevisitEdge& edge) : edge_(edge) {}
  int dimension() const override { return 2; }
  void evaluate(const NavState& a, const NavState& b, Residual& r, Jacobian* Ja,
                Jacobian* Jb) const override;
  double robust_threshold(int row) const override;

 private:
  RevisitEdge edge_;
};

// A position from outside, between two states in a row: L^-1 ((1 - s) c_a + s c_b - p) with c = p +
// R l of the antenna, s the share of the time between them, L L^T the covariance; x and y, m. The
// antenna is an unknown, too.
class FixFactor {
 public:
  // p and covariance in the frame of the states; share: of the seconds between them, where the fix
  // comes without delay. Throws std::invalid_argument if the covariance is not positive definite.
  FixFactor(const Eigen::Vector2d& p, const Eigen::Matrix2d& covariance,
            const Eigen::Vector3d& lever_arm, double share, double seconds);
  // antenna: what is added to x and y of the lever arm (m), and how late the fix comes (s).
  struct Jacobians {
    Jacobian a, b;
    Eigen::Matrix<double, 2, 3> antenna;
  };
  Eigen::Vector2d evaluate(const NavState& a, const NavState& b, const Eigen::Vector3d& antenna,
                           Jacobians* J) const;

 private:
  Eigen::Vector2d p_;
  Eigen::Matrix2d whitening_;
  Eigen::Vector3d lever_arm_;
  double share_, seconds_;
};

}  // namespace gprodom
