// A robot that drives straight ahead and back over one line of ground, for tests of the mapper.
#pragma once

#include <cmath>
#include <optional>
#include <utility>

#include "gpr/synthetic_ground.h"
#include "map/mapper.h"

namespace gprodom {

struct Way {
  double from, to;     // m along x, of the robot
  int antenna = 0;     // that measures
  double lever = 0.0;  // m, of its centre
  double ahead = 0.0;  // m, of odom
};

// Drives straight ahead or back over one ground. The odometry does not say how far it is off.
class StraightRobot {
 public:
  explicit StraightRobot(Mapper& mapper) : mapper_(mapper) {}

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
      PathState state;
      state.time = from_seconds(1000.0 + seconds_);
      state.pose.p.x() = x + way.ahead;
      state.covariance = (4e-4 * driven_ + lost_m2) * Eigen::Matrix3d::Identity();
      state.covariance(2, 2) = 1e-8 * driven_;
      state.pose_covariance = state.covariance;
      input.states.push_back(state);
      for (int k = 2; k >= 0 && driven_ > 0 && i > 0; --k) {
        const double ago = k / 3.0;
        GprTrace trace = radar_.measure(ground_, x - ago * step + way.lever,
                                        1000.0 + seconds_ - ago * to_seconds(kInterval));
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
  gpr::SyntheticGround ground_{7, 60.0};
  gpr::SyntheticRadar radar_{3, 60.0};
  double seconds_ = 0.0;
  int driven_ = 0;
};

}  // namespace gprodom
