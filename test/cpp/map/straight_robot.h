// A robot that drives straight ahead and back over one line of ground, for tests of the mapper.
#pragma once

#include <cmath>
#include <utility>

#include "gpr/synthetic_ground.h"
#include "map/mapper.h"

namespace gprodom {

// On a straight line ahead. The variance is of x, y and yaw.
inline PathState state_at(TimeNs time, double x, double variance) {
  PathState state;
  state.time = time;
  state.pose.p.x() = x;
  state.covariance = state.pose_covariance = variance * Eigen::Matrix3d::Identity();
  return state;
}

// At `to` the robot is where it was at `from`, as another process tells it.
inline Displacement seen_again(TimeNs from, TimeNs to, bool mirrored) {
  Displacement revisit;
  revisit.kind = DisplacementKind::kRevisit;
  revisit.from = from;
  revisit.to = to;
  revisit.sigma_m = 0.01;
  revisit.mirrored = mirrored;
  revisit.valid = true;
  return revisit;
}

struct Way {
  double from, to;     // m along x, of the robot
  int antenna = 0;     // that measures
  double lever = 0.0;  // m, of its centre
  double ahead = 0.0;  // m, of odom
};

// Drives straight ahead or back over one ground. The odometry does not say how far it is off.
class StraightRobot {
 public:
  explicit StraightRobot(Mapper& mapper, unsigned ground = 7, double begin_s = 1000.0)
      : mapper_(mapper), ground_(ground, 60.0), seconds_(begin_s) {}

  MapAnswer drive(const Way& way) {
    MapAnswer last;
    MapInput input;
    const int direction = way.to > way.from ? 1 : -1;
    constexpr double kSpeed = 0.5;             // m/s
    constexpr TimeNs kInterval = 200'000'000;  // ns from state to state
    const int states = static_cast<int>(std::abs(way.to - way.from) / kSpeed * 5);
    for (int i = 0; i < states; ++i, seconds_ += to_seconds(kInterval), ++driven_) {
      const double step = direction * kSpeed * to_seconds(kInterval);
      const double x = way.from + i * step;
      PathState state = state_at(from_seconds(seconds_), x + way.ahead, 4e-4 * driven_ + lost_m2);
      state.covariance(2, 2) = state.pose_covariance(2, 2) = 1e-8 * driven_;
      input.states.push_back(state);
      for (int k = 2; k >= 0 && driven_ > 0 && i > 0; --k) {
        const double ago = k / 3.0;
        GprTrace trace = radar_.measure(ground_, x - ago * step + way.lever,
                                        seconds_ - ago * to_seconds(kInterval));
        trace.antenna_id = way.antenna;
        input.traces.push_back(std::move(trace));
      }
      if (i % 10 < 9) continue;
      MapAnswer answer = mapper_.run(input);
      revisits += answer.revisits.size();
      located |= answer.located;
      if (answer.pose) last = std::move(answer);
      input = {};
    }
    return last;
  }

  double lost_m2 = 0.0;  // variance of the position beside that of the way
  std::size_t revisits = 0;
  bool located = false;

 private:
  Mapper& mapper_;
  gpr::SyntheticGround ground_;
  gpr::SyntheticRadar radar_{3, 60.0};
  double seconds_;
  int driven_ = 0;
};

}  // namespace gprodom
