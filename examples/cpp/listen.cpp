// Prints the robot's position as gprodomd estimates it: listen [COUNT [URL]]
//
// COUNT messages of the channel ODOMETRY_MAP (0: without end), from LCM at URL.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>

#include "gprodom/odometry_t.hpp"

// Position in `frame` (m), heading (deg), and the standard deviation of the position (m).
static void show(const lcm::ReceiveBuffer*, const std::string&, const gprodom::odometry_t* m,
                 void*) {
  const double w = m->orientation[0], x = m->orientation[1];
  const double y = m->orientation[2], z = m->orientation[3];
  const double yaw = std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  const double sigma = std::sqrt(m->pose_covariance[0] + m->pose_covariance[7]);
  std::printf("%lld %s %.3f %.3f %.1f +-%.3f\n", static_cast<long long>(m->utime), m->frame.c_str(),
              m->position[0], m->position[1], yaw * 180 / M_PI, sigma);
  std::fflush(stdout);
}

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 0;
  lcm::LCM lcm(argc > 2 ? argv[2] : "udpm://239.255.76.67:7667?ttl=0");
  if (!lcm.good()) return 1;
  lcm.subscribeFunction("ODOMETRY_MAP", &show, static_cast<void*>(nullptr));
  for (int handled = 0; count == 0 || handled < count; ++handled) {
    if (lcm.handle() != 0) return 1;
  }
  return 0;
}
