#include "motion/slip/slip_belief.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/kernels/so3.h"

namespace gprodom {

using slip::Hypothesis;
using slip::kOutlier;
using slip::Mode;
using slip::Vector;
namespace row_of = slip::row;

namespace {

constexpr std::size_t kHypotheses = 15;

// Power of a hypothesis' probability in left(), as of a coarsened posterior (Miller and Dunson,
// JASA 2019). Chosen, not learnt: (1 - r) / (1 + r) for blocks of 1 s whose errors, beside the one
// that is a state, have the correlation r = 2/3.
constexpr double kEvidence = 0.2;
constexpr double kBlock_s = 0.99;    // over which measurements are summed; between branches
constexpr double kRolls_mps = 0.01;  // of the wheel; below, no slip begins or ends

// Rates at which a change of slip ends (l becomes 0) or becomes a slip that holds.
constexpr double kChangeEnds = 1 / 6.0, kChangeHolds = 1 / 5.0;  // 1/s
constexpr double kLongestBlock = 2.5;  // s; in a longer one these would sum up to more than 1
// A slip ends at l = 0. Density of l there while it ends, against chance.
constexpr double kTowardsGrip = 5.0;
// Random walk of l, per root second: over the slip's size while it changes; while it holds.
constexpr double kChange = 0.16, kHold = 0.01;
constexpr double kChangeForgets_s = 30.0, kGripForgets_s = 2.0;
constexpr double kGripSigma = 0.01;  // of l while the wheel grips: unevenness of the ground

constexpr std::size_t kSeenAfter = 5;  // blocks, after which most slip has been detected

constexpr double kGroundGuess = 0.5;   // sigma of ln(metres / lengths) after the first span
constexpr double kGroundWalk = 0.01;   // 1/sqrt(m)
constexpr double kSlowest_mps = 0.05;  // mean speed of a span that is compared
constexpr double kUnknownSpeed = 1.0;  // m/s, one standard deviation
// An undetected change of the gyro bias tilts the attitude, and gravity then looks like slip. So
// the walk is that of a cheap gyro, whatever the data sheet says.
constexpr double kAccelBiasWalk = 1e-4, kGyroBiasWalk = 1e-4;  // per root second
// Tilt that the gyro misses and aliased vibration make accelerations wrong for seconds, by as much
// as they are noisy over one second. Taken for white noise, three seconds of it in one bend put the
// wheel of a car 0.3 m wide 0.45 +- 0.14 m aside. (s)
constexpr double kAccelErrorLasts_s = 20.0;

}  // namespace

SlipBelief::SlipBelief(const Config& config)
    : model_(slip_model(config.wheel)),
      enabled_(config.wheel.enabled && config.wheel.slip_share > 0),
      share_(model_.share),
      unseen_{config.wheel.noise, config.smoother.lag},
      wheel_noise_(config.wheel.noise),
      wheel_floor_(config.wheel.noise_floor),
      position_(config.wheel),
      lag_(static_cast<std::size_t>(config.smoother.lag * config.smoother.state_rate)) {}

void SlipBelief::restart() {
  hypotheses_.clear();
  intervals_.clear();
  block_ = {};
  blocks_ = 0;
}

void SlipBelief::begin(const StateResult& newest) {
  q_ = newest.state.q_odom_body;
  gyro_bias_ = newest.state.gyro_bias;
  scale_ = newest.state.wheel_scale;
  ground_known_ = false;
  hypotheses_ = {first_hypothesis(newest)};
  axes_.branch(hypotheses_);
}

Hypothesis SlipBelief::first_hypothesis(const StateResult& newest) const {
  const NavState& at = newest.state;
  const Eigen::Vector3d forwards = slip::heading(q_);
  Hypothesis h;
  h.x[row_of::kSpeed] = forwards.dot(at.v_odom);
  h.x.segment<2>(row_of::kAccelBias) = at.accel_bias.head<2>();
  // A state's error theta turns gravity: what leaks into x and y is g (-theta_y, theta_x).
  Eigen::Matrix<double, slip::kDim, kStateDim> J;
  J.setZero();
  J.block<1, 3>(row_of::kSpeed, row::kV) = forwards.transpose();
  J(row_of::kTilt, row::kTheta + 1) = -1;
  J(row_of::kTilt + 1, row::kTheta) = 1;
  J.block<2, 2>(row_of::kAccelBias, row::kBa).setIdentity();
  J.block<2, 2>(row_of::kGyroBias, row::kBg).setIdentity();
  J(row_of::kScale, row::kScale) = 1 / at.wheel_scale;
  h.P = J * newest.covariance * J.transpose();
  h.P(row_of::kSlip, row_of::kSlip) = kGripSigma * kGripSigma;
  h.x[row_of::kWheelY] = position_.learnt().y_m;
  h.P(row_of::kWheelY, row_of::kWheelY) = std::pow(position_.learnt().sigma_m, 2);
  return h;
}

// After a long gap of the IMU: attitude and speed are those of the newest state, and as uncertain.
// The speed is the wheel's, so it is not known where the wheel slips.
void SlipBelief::resume(const StateResult& newest) {
  const Hypothesis fresh = first_hypothesis(newest);
  q_ = newest.state.q_odom_body;
  constexpr int kCount = row_of::kAccelBias;  // speed and tilt
  for (Hypothesis& h : hypotheses_) {
    h.x.head<kCount>() = fresh.x.head<kCount>();
    h.P.topRows<kCount>().setZero();
    h.P.leftCols<kCount>().setZero();
    h.P.topLeftCorner<kCount, kCount>() = fresh.P.topLeftCorner<kCount, kCount>();
    h.P(row_of::kSpeed, row_of::kSpeed) += kUnknownSpeed * kUnknownSpeed;
  }
}

void SlipBelief::advance(const StateInput& given, const StateResult& newest, const ImuNoise& rest,
                         double driving_accel_density) {
  if (!enabled_) return;
  if (given.gyro_bias || given.speed_correction) restart();
  StateInput input = given;
  // The configured noise contains tilt and slip, which are states here.
  if (driving_accel_density > 0) input.noise.accel_density = driving_accel_density;
  if (hypotheses_.empty()) begin(newest);
  gyro_bias_.z() = newest.state.gyro_bias.z();
  rest_ = rest;
  const bool gap = imu_silent(input.steps);
  if (newest.carried && !gap) resume(newest);
  // The first interval after a sudden slip may contain the end of it.
  const bool usable = input.has_wheel && !input.wheel_contradicted;
  const bool usable_before = std::exchange(usable_before_, usable);
  const bool wheel = usable && usable_before;
  if (block_.intervals > 0 &&
      (block_.wheel != wheel || block_.standing != input.standing || block_.gap != gap)) {
    block_.wheel = block_.wheel && wheel;  // a sudden slip begins before it is detected
    close();
  }
  block_.wheel = wheel;
  block_.standing = input.standing;
  block_.gap = gap;
  intervals_.push_back({input.time, wheel, blocks_});
  if (intervals_.size() > lag_) intervals_.pop_front();
  const slip::LevelMotion motion(input.steps, q_, gyro_bias_);
  q_ = motion.q;
  block_.add(input, motion, scale_);
  if (block_.dt >= kBlock_s) close();
}

// Updates the hypotheses with the block's measurements.
void SlipBelief::close() {
  const slip::Block& b = block_;
  const bool turns = b.wheel && std::abs(b.wheel_m) > kRolls_mps * b.dt;
  const bool rolls = !b.standing && (turns || b.gap);
  way_m_ += std::abs(b.wheel_m);
  if (rolls) branch(b.dt);
  for (Hypothesis& h : hypotheses_) {
    predict(h, rolls);
    if (!b.gap) weigh(h);
    // While the wheel grips, l is unevenness of the ground, which the wheel's noise covers.
    h.past.push_back(h.mode == Mode::kGrips
                         ? slip::Past{}
                         : slip::Past{h.x[row_of::kSlip], h.P(row_of::kSlip, row_of::kSlip), 1.0});
    if (h.past.size() > lag_) h.past.pop_front();
  }
  slip::prune(hypotheses_, kHypotheses);
  if (rolls && !b.gap) learn_share();
  take_out_common_error();
  position_.learn(hypotheses_);
  axes_.learn(hypotheses_);
  block_ = {};
  ++blocks_;
}

// The share falls on a robot that never slips. It is counted kSeenAfter blocks late, when most slip
// has been detected.
void SlipBelief::learn_share() {
  double slips = 0.0;
  for (const Hypothesis& h : hypotheses_) {
    const std::size_t ago = std::min(kSeenAfter, h.past.size() - 1);
    slips += std::exp(h.log_weight) * h.past[h.past.size() - 1 - ago].slips;
  }
  const double prior = std::pow(model_.sigma(), 2);
  const double left =
      unseen_.variance(prior, std::abs(block_.wheel_m) / block_.dt, block_.noise) / prior;
  share_.add(block_.dt, slips, 1 - left);
}

// Replaces each hypothesis by those for each change of mode within the last second.
void SlipBelief::branch(double block_s) {
  const double share = share_.value(), seconds = std::min(block_s, kLongestBlock);
  const double begins = seconds * share / ((1 - share) * model_.lasts_s);
  const double ends = seconds * kChangeEnds, holds = seconds * kChangeHolds,
               changes = seconds / model_.lasts_s;
  std::vector<Hypothesis> all;
  const auto add = [&all](Hypothesis h, Mode mode, double probability) {
    h.mode = mode;
    h.log_weight += std::log(probability);
    all.push_back(std::move(h));
  };
  const auto jump = [&](Hypothesis h, double sigma, Mode mode, double probability) {
    h.set_slip(0.0, sigma);
    add(std::move(h), mode, probability);
  };
  for (const Hypothesis& h : hypotheses_) {
    // A slip may end with a jump. That with which it begins is SlipWatch's to see, except in a gap.
    if (h.mode != Mode::kGrips) jump(h, kGripSigma, Mode::kGrips, changes);
    if (h.mode == Mode::kGrips && block_.gap) jump(h, model_.size, Mode::kHolds, begins);
    if (h.mode == Mode::kGrips) {
      add(h, Mode::kGrips, 1 - begins);
      add(h, Mode::kChanges, begins);
    } else if (h.mode == Mode::kHolds) {
      add(h, Mode::kHolds, 1 - changes);
      add(h, Mode::kChanges, changes);
    } else {
      add(h, Mode::kChanges, 1 - ends - holds);
      add(h, Mode::kHolds, holds);
      Hypothesis ended = h;
      Vector H = Vector::Zero();
      H[row_of::kSlip] = 1;
      ended.log_weight += ended.update(H, -h.x[row_of::kSlip], kGripSigma * kGripSigma);
      constexpr double kRootTwoPi = 2.5066;
      add(std::move(ended), Mode::kGrips, ends * kTowardsGrip / kRootTwoPi);
    }
  }
  hypotheses_ = std::move(all);
  slip::prune(hypotheses_, kHypotheses);
}

// Prediction: speed from the accelerations, without bias and gravity by tilt; l by its mode.
void SlipBelief::predict(Hypothesis& h, bool rolls) const {
  const slip::Block& b = block_;
  const double dt = b.dt, way = std::abs(b.wheel_m);
  slip::Matrix F = slip::Matrix::Identity();
  const Eigen::RowVector2d forwards = h.axes().row(0);
  const Eigen::Vector2d gained = b.gained - errors(h);
  F.block<1, 2>(row_of::kSpeed, row_of::kTilt) = -forwards * b.by_tilt();
  F.block<1, 2>(row_of::kSpeed, row_of::kAccelBias) = -dt * forwards;
  F.block<1, 2>(row_of::kSpeed, row_of::kAxes) = gained.transpose();
  F.block<2, 1>(row_of::kTilt, row_of::kGyroBias) = -b.leftwards;
  F.block<2, 1>(row_of::kTilt, row_of::kGyroBias + 1) = b.forwards;
  const double kept = std::exp(-way / slip::GroundNoise::kPlace);
  F(row_of::kPlace, row_of::kPlace) = kept;
  Vector added = Vector::Zero();
  added[row_of::kSpeed] = b.speed_variance;
  added.segment<2>(row_of::kTilt).setConstant(b.tilt_variance);
  added.segment<2>(row_of::kAccelBias).setConstant(kAccelBiasWalk * kAccelBiasWalk * dt);
  added.segment<2>(row_of::kGyroBias).setConstant(kGyroBiasWalk * kGyroBiasWalk * dt);
  added[row_of::kGround] = kGroundWalk * kGroundWalk * way;
  added[row_of::kPlace] = std::pow(ground_.place_sigma(), 2) * (1 - kept * kept);
  const double error = b.noise.accel_density;  // the noise over one second
  const double lasts = b.standing ? 0.0 : std::exp(-dt / kAccelErrorLasts_s);
  F(row_of::kSpeed, row_of::kAccelError) = -dt;
  F(row_of::kAccelError, row_of::kAccelError) = lasts;
  added[row_of::kAccelError] = b.standing ? 0.0 : error * error * (1 - lasts * lasts);
  double& phi = F(row_of::kSlip, row_of::kSlip);
  if (rolls && h.mode == Mode::kGrips) {
    phi = std::exp(-dt / kGripForgets_s);
    added[row_of::kSlip] = kGripSigma * kGripSigma * (1 - phi * phi);
  } else if (rolls && h.mode == Mode::kChanges) {
    phi = std::exp(-dt / kChangeForgets_s);
    added[row_of::kSlip] = std::pow(kChange * model_.size, 2) * dt;
  } else if (rolls) {
    added[row_of::kSlip] = kHold * kHold * dt;
  }
  const double speed = h.x[row_of::kSpeed] + forwards * gained - dt * h.x[row_of::kAccelError];
  h.x = F * h.x;
  h.x[row_of::kSpeed] = speed;
  h.P = F * h.P * F.transpose();
  h.P.diagonal() += added;
}

double SlipBelief::axes_error(const std::vector<MotionStep>& steps) const {
  if (hypotheses_.empty()) return 0.0;  // no attitude yet
  const slip::LevelMotion motion(steps, q_, gyro_bias_);
  return motion.dt > 0 ? axes_.error_sigma(motion.mean_acceleration()) : 0.0;
}

// Moves the mean of tilt and gyro bias over all hypotheses into attitude and bias, so that the
// errors stay small.
void SlipBelief::take_out_common_error() {
  Vector mean = Vector::Zero();
  for (const Hypothesis& h : hypotheses_) mean += std::exp(h.log_weight) * h.x;
  const Eigen::Vector2d tilt = mean.segment<2>(row_of::kTilt),
                        bias = mean.segment<2>(row_of::kGyroBias);
  q_ = (so3::exp(Eigen::Vector3d(tilt.y(), -tilt.x(), 0.0)) * q_).normalized();
  gyro_bias_.head<2>() += bias;
  for (Hypothesis& h : hypotheses_) {
    h.x.segment<2>(row_of::kTilt) -= tilt;
    h.x.segment<2>(row_of::kGyroBias) -= bias;
  }
}

void SlipBelief::compare(const gpr::PathLength& path, double wheel_m) {
  const double seconds = to_seconds(path.to - path.from), way = std::abs(wheel_m) / scale_;
  if (hypotheses_.empty() || !path.valid || way < kSlowest_mps * seconds) return;
  if (std::exchange(unit_, path.unit) != path.unit) {
    ground_known_ = false;
    ground_.begin_unit();
  }
  const double x = std::log(way / path.lengths);
  Vector H = Vector::Zero();
  H[row_of::kSlip] = -1;
  H[row_of::kScale] = 1;
  H[row_of::kGround] = 1;
  H[row_of::kPlace] = 1;
  double expected = 0.0;
  for (Hypothesis& h : hypotheses_) {
    if (!ground_known_) {
      h.x[row_of::kGround] = x + h.x[row_of::kSlip] - h.x[row_of::kScale];
      h.P(row_of::kGround, row_of::kGround) = kGroundGuess * kGroundGuess;
    }
    h.log_weight += h.update(H, x - H.dot(h.x), std::pow(ground_.span_sigma(), 2), kOutlier);
  }
  ground_known_ = true;
  slip::prune(hypotheses_, kHypotheses);
  for (const Hypothesis& h : hypotheses_)
    expected += std::exp(h.log_weight) * (h.x[row_of::kSlip] - h.x[row_of::kScale]);
  ground_.add(way_m_, x + expected);
}

std::vector<IntervalSlip> SlipBelief::recent() const {
  std::vector<IntervalSlip> result;
  if (blocks_ == 0) return result;
  for (const Interval& interval : intervals_) {
    if (!interval.wheel) continue;
    const Sums all = sums(interval, 1.0);
    const double variance = all.slips * (all.square - all.mean * all.mean);
    const double mean =
        all.mean * (all.slips > 0 ? slip::without_unlikely(all.slips) / all.slips : 1.0);
    result.push_back({interval.to, mean, std::sqrt(std::max(0.0, variance))});
  }
  return result;
}

std::optional<double> SlipBelief::left() const {
  const auto oldest = std::find_if(intervals_.begin(), intervals_.end(),
                                   [](const Interval& interval) { return interval.wheel; });
  if (blocks_ == 0 || oldest == intervals_.end()) return std::nullopt;
  const Sums all = sums(*oldest, kEvidence);
  if (all.weight <= 0) return std::nullopt;
  const double mean = all.mean / all.weight;
  return std::max(0.0, all.square / all.weight - mean * mean);
}

SlipBelief::Sums SlipBelief::sums(const Interval& interval, double power) const {
  const std::size_t ago = blocks_ - 1 - std::min(interval.block, blocks_ - 1);
  Sums all;
  for (const Hypothesis& h : hypotheses_) {
    if (ago >= h.past.size()) continue;
    const slip::Past& past = h.past[h.past.size() - 1 - ago];
    const double w = std::exp(power * h.log_weight);
    all.weight += w;
    all.mean += w * past.l;
    all.square += w * (past.variance + past.l * past.l);
    all.slips += w * past.slips;
  }
  return all;
}

}  // namespace gprodom
