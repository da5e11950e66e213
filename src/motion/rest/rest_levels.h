// What IMU and wheel show while the robot stands.
#pragma once

#include <optional>
#include <vector>

#include "estimation/initializer.h"
#include "gprodom/types.h"

namespace gprodom {

class RestLevels {
 public:
  // From the standstill at a start. wheel_mps: unsigned speed that the wheel showed.
  void measure(const std::vector<ImuSample>& samples, double wheel_mps);
  void begin(const InitialState& initial);
  // The robot stood for a second. After a start on the move, the levels are those of its first such
  // second, and are replaced by those of one that is clearly quieter: after a stop the body rocks.
  void stood(const std::vector<ImuSample>& samples, double wheel_mps);

  bool known() const { return known_; }                     // measured at a standstill
  const ImuNoise& noise() const { return noise_; }          // the sensor's own, while not known
  const ImuNoise& vibration() const { return vibration_; }  // from sample to sample
  double wheel_mps() const { return wheel_mps_; }

 private:
  ImuNoise noise_, vibration_;
  std::optional<ImuNoise> own_;  // the sensor's, after a start on the move
  double wheel_mps_ = 0.0;
  bool known_ = false;
};

}  // namespace gprodom
