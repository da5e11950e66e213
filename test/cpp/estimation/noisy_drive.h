// A simulated drive for tests of the smoother.
#pragma once

#include <cmath>
#include <memory>

#include "estimation/fixed_lag_smoother.h"
#include "support/noise.h"

namespace gprodom {

inline MarginalPrior origin_prior(const NavState& x, const StateVector& sigma) {
  MarginalPrior prior;
  prior.x0 = {x};
  prior.A = sigma.cwiseInverse().asDiagonal();
  prior.b = StateVector::Zero();
  return prior;
}

// A noisy drive round a circle: IMU and wheel factors between states.
struct NoisyDrive {
  Noise n{7};
  const double speed = 0.6, turn = 0.4, dt = 0.005;
  const Eigen::Vector3d gravity{0, 0, -9.80665};
  const ImuNoise noise{1.6e-4, 5.9e-4};

  Eigen::Vector3d white(double density) { return n.vector(density / std::sqrt(dt)); }

  NavState start() const {
    NavState x;
    x.v_odom = Eigen::Vector3d(speed, 0, 0);
    return x;
  }

  FixedLagSmoother smoother(double lag, const SolverOptions& options, SolverKind kind,
                            const StateVector& sigma) const {
    return FixedLagSmoother(lag, options, kind, start(), origin_prior(start(), sigma));
  }

  void extend(FixedLagSmoother& smoother) {
    const NavState last = smoother.newest();
    ImuPreintegration imu(noise, last.gyro_bias, last.accel_bias);
    WheelIncrement wheel(last.gyro_bias);
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector3d rate = Eigen::Vector3d(0, 0, turn) + white(noise.gyro_density);
      imu.integrate(Eigen::Vector3d(0, speed * turn, 0) - gravity + white(noise.accel_density),
                    rate, dt);
      wheel.integrate(rate, dt, speed * dt * (1 + 0.02 * n()));
    }
    NavState next = last;
    const auto d = imu.delta();
    const double T = imu.duration();
    next.time += from_seconds(T);
    next.p_odom += last.v_odom * T + 0.5 * gravity * T * T + last.q_odom_body * d.p;
    next.v_odom += gravity * T + last.q_odom_body * d.v;
    next.q_odom_body = last.q_odom_body * d.q;
    const auto b = smoother.add_state(next), a = b - 1;
    smoother.add_factor(a, b, std::make_shared<ImuFactor>(imu, gravity));
    smoother.add_factor(a, b, std::make_shared<RandomWalkFactor>(1e-5, 1e-4, 1e-6));
    smoother.add_factor(a, b,
                        std::make_shared<WheelFactor>(wheel, Eigen::Vector3d(0.1, 0, 0),
                                                      Eigen::Vector3d(4e-6, 1e-6, 1e-6), 1.5));
  }
};

}  // namespace gprodom
