// Does the wheel slip, or does the accelerometer err? The probability that the wheel slipped in
// each of the last state intervals, and where a single wheel is.
//
// Speed by the wheel and speed by the accelerations differ for one of two reasons: the wheel slips,
// or the accelerations have an error that lasts (tilt, mounting, aliased vibration). Neither the
// moments of slip nor the size of that error are known before. So a bank of sizes is kept, and for
// each of them hypotheses of when the wheel began and ceased to slip. Each hypothesis is a Kalman
// filter along the track. What wheel, standstills and radar say moves the weights of all of them,
// so that a robot whose accelerometer errs by much is never taken for one that slips.
// docs/estimation.md, "Grip".
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "motion/slip/wheel_position.h"

namespace gprodom {

// What has been learnt about the sensors.
struct GripNoise {
  double wheel = 0.0;   // m/sqrt(m), from left and right wheels; 0: not learnt
  double late_s = 0.0;  // how long its values are held, or delayed against the IMU
  // m/s^2/sqrt(Hz), of the accelerations from sample to sample.
  double accel_density = 0.0;
};

class GripFilter {
 public:
  explicit GripFilter(const Config& config);

  // One state interval. at: the state at its beginning, for attitude, biases and scale.
  void advance(const StateInput& input, const StateResult& at, const GripNoise& noise);

  // An unsigned distance (m) by the radar.
  void compare(const Displacement& radar);

  const slip::WheelPosition& position() const { return position_; }
  void resume(const slip::LearntPosition& earlier) { position_.resume(earlier); }

  // Probability that the wheel slipped in the newest interval.
  double slips() const;
  // More likely than not, in a part of the time.
  bool slipped(TimeNs from, TimeNs to) const;

 private:
  // Rows of a hypothesis: speed (m/s), error of the acceleration that lasts for seconds (m/s^2), ln
  // of the wheel's scale over the window's, slip (m/s: speed of the wheel less that of the ground),
  // error of the acceleration by the window's tilt and bias (m/s^2), lateral position of the wheel
  // (m, y of body).
  static constexpr int kSpeed = 0, kError = 1, kScale = 2, kSlip = 3, kLeak = 4, kWheelY = 5,
                       kDim = 6;
  using Vector = Eigen::Matrix<double, kDim, 1>;
  using Matrix = Eigen::Matrix<double, kDim, kDim>;
  struct Hypothesis {
    std::size_t size = 0;  // index of the acceleration's error
    bool slips = false;
    bool ends = false;  // the slip, within this interval
    int age = 0;        // intervals since it began to slip, or to grip
    double log_weight = 0.0;
    Vector x = Vector::Zero();
    Matrix P = Matrix::Zero();
    Eigen::VectorXf slipped;  // probability in each of the last intervals, newest first
    Eigen::VectorXf way_m;    // of the ground, likewise
    double update(const Vector& H, double innovation, double variance);
    void set(int row, double sigma);
    void jump(double sigma_mps);
    void grip();
    void merge(Hypothesis other);
  };
  struct Interval {
    TimeNs from, to;
  };
  // What the sensors say of one interval.
  struct Step {
    double dt = 0, gained = 0, behind = 0;  // s; m/s; m/s, end speed less mean speed
    double turn_rate = 0;                   // rad/s, mean
    double turn_speed = 0;                  // m/s^2, centripetal
    double white = 0;                       // m^2/s^2
    double leak_mps2 = 0;                   // Leak::mps2 at the end
    double tilted = 0;                      // m^2/s^4, of the leak, by the gyro's noise
    std::optional<double> wheel;            // m/s at the end
    double wheel_variance = 0;              // m^2/s^2, with what a delay adds
    bool standing = false, gap = false;
  };
  // The part of gravity and bias that the window believes to be in the forward acceleration.
  struct Leak {
    double mps2 = 0.0, variance = 0.0;
  };

  void begin(const StateResult& at);
  Leak leak_of(const StateResult& at) const;
  void follow_leak(const StateResult& at);
  Step step_of(const StateInput& input, const StateResult& at, const GripNoise& noise) const;
  static void remember(Hypothesis& h, const Step& step);
  void branch(const Step& step);
  void predict(Hypothesis& h, const Step& step) const;
  void weigh(Hypothesis& h, const Step& step) const;
  void merge();
  void normalise();
  void learn_position();
  void forget(double dt);

  const WheelConfig config_;
  slip::WheelPosition position_;
  const std::size_t lag_;  // intervals of the window
  std::vector<double> sizes_;
  std::vector<Hypothesis> hypotheses_;
  std::deque<Interval> intervals_;  // newest first
  bool stood_ = false;              // in the last interval
  double leak_mps2_ = 0.0;          // as believed by the state with which the last interval began
};

}  // namespace gprodom
