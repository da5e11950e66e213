// smoother_update MEASUREMENTS OUT.csv [KEY=VALUE]...: the state estimator on measurements that are
// already cut into state intervals, each update timed. bench/smoothers.py writes MEASUREMENTS and
// runs GTSAM's smoothers on the same:
//
//   initial TIME qw qx qy qz bg(3) ba(3) sigma(16)      TIME: ns; sigmas in the order of
//   nav_state.h interval TIME GYRO_DENSITY ACCEL_DENSITY HAS_WHEEL N
//     N lines: dt, specific force (3), rate (3), wheel distance; SI, body axes
//
// OUT.csv has a row for each interval: position, and the thread's CPU time of the update, from
// preintegration to the newest covariance.
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "estimation/state_estimator.h"
#include "gprodom/config.h"

namespace {

using namespace gprodom;

double thread_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <typename Derived>
void read(std::istream& in, Eigen::MatrixBase<Derived>& v) {
  for (Eigen::Index i = 0; i < v.size(); ++i) in >> v(i);
}

InitialState read_initial(std::istream& in) {
  InitialState initial;
  NavState& x = initial.state;
  Eigen::Vector4d q;
  StateVector sigma;
  in >> x.time;
  read(in, q);
  read(in, x.gyro_bias);
  read(in, x.accel_bias);
  read(in, sigma);
  x.q_odom_body = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  initial.prior = gaussian_prior(x, sigma.cwiseAbs2().asDiagonal());
  return initial;
}

StateInput read_interval(std::istream& in) {
  StateInput input;
  std::size_t n = 0;
  in >> input.time >> input.noise.gyro_density >> input.noise.accel_density >> input.has_wheel >> n;
  input.steps.resize(n);
  for (MotionStep& step : input.steps) {
    in >> step.dt;
    read(in, step.acceleration);
    read(in, step.angular_velocity);
    in >> step.wheel_m;
  }
  return input;
}

void run(std::istream& in, std::ostream& out, const Config& config) {
  std::string word;
  if (!(in >> word) || word != "initial") throw std::runtime_error("expected 'initial' at first");
  StateEstimator estimator(config, read_initial(in));
  out << "x,y,z,cpu_s\n" << std::setprecision(12);
  while (in >> word) {
    if (word != "interval") throw std::runtime_error("expected 'interval', got '" + word + "'");
    const StateInput input = read_interval(in);
    if (!in) throw std::runtime_error("an interval is cut short");
    const double begin = thread_cpu_s();
    const Eigen::Vector3d p = estimator.add(input).state.p_odom;
    const double cpu = thread_cpu_s() - begin;
    out << p.x() << ',' << p.y() << ',' << p.z() << ',' << cpu << '\n';
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: smoother_update MEASUREMENTS OUT.csv [KEY=VALUE]...\n";
    return 2;
  }
  try {
    std::ifstream in(argv[1]);
    std::ofstream out(argv[2]);
    if (!in) throw std::runtime_error(std::string(argv[1]) + ": cannot be read");
    run(in, out, gprodom::default_config(std::vector<std::string>(argv + 3, argv + argc)));
    if (!out.flush()) throw std::runtime_error(std::string(argv[2]) + ": cannot be written");
  } catch (const std::exception& error) {
    std::cerr << "smoother_update: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
