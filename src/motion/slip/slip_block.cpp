#include "motion/slip/slip_block.h"

#include "estimation/kernels/so3.h"

namespace gprodom::slip {

Eigen::Vector3d heading(const Eigen::Quaterniond& q_world_body) {
  const Eigen::Vector3d x = q_world_body * Eigen::Vector3d::UnitX();
  return Eigen::Vector3d(x.x(), x.y(), 0.0).normalized();
}

LevelMotion::LevelMotion(const std::vector<MotionStep>& steps,
                         const Eigen::Quaterniond& q_world_body, const Eigen::Vector3d& gyro_bias)
    : q(q_world_body) {
  const Eigen::Vector3d gravity(0, 0, kStandardGravity);
  for (const MotionStep& step : steps) {
    const Eigen::Vector3d phi = (step.angular_velocity - gyro_bias) * step.dt;
    const Eigen::Vector3d more = (q * so3::exp(0.5 * phi) * step.acceleration - gravity) * step.dt;
    dp += dv * step.dt + 0.5 * more * step.dt;
    dv += more;
    q = (q * so3::exp(phi)).normalized();
    dt += step.dt;
    turned += phi;
  }
  forwards = (heading(q_world_body) + heading(q)).normalized();
  leftwards = Eigen::Vector3d::UnitZ().cross(forwards);
}

void Block::add(const StateInput& input, const LevelMotion& motion, double wheel_scale) {
  for (const MotionStep& step : input.steps) {
    const ImuNoise& of_step = step.bridged ? kBridgedImuNoise : input.noise;
    speed_variance += of_step.accel_density * of_step.accel_density * step.dt;
    tilt_variance += of_step.gyro_density * of_step.gyro_density * step.dt;
    wheel_m += step.wheel_m / wheel_scale;
  }
  const Eigen::Vector2d more = motion.level(motion.dv);
  behind_m += more * (dt + motion.dt) - motion.level(motion.dp);
  const double turn = turned + 0.5 * motion.turned.z();
  turned_before += more * turn;
  turn_s += motion.dt * turn;
  gained += more;
  rates += motion.turned;
  turned += motion.turned.z();
  dt += motion.dt;
  forwards += motion.dt * motion.forwards.head<2>();
  leftwards += motion.dt * motion.leftwards.head<2>();
  wheel_variance += input.wheel_sigma_m * input.wheel_sigma_m;
  noise = input.noise;
  ++intervals;
}

Eigen::Matrix2d Block::by_tilt() const {
  Eigen::Matrix2d axes;  // rows: along, and to the left
  axes.row(0) = forwards.transpose();
  axes.row(1) = leftwards.transpose();
  return kStandardGravity * axes;
}

}  // namespace gprodom::slip
