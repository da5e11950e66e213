#include "motion/grip_filter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "estimation/graph/slip_model.h"

namespace gprodom {

namespace {

// The error of the accelerations: for how long it lasts, and the sizes that are held possible, from
// what the bias of a good sensor moves by to what a shaken and badly mounted one shows. A factor of
// three from one to the next costs at most 0.15 nats an interval against the true size.
constexpr double kErrorLasts_s = 2.0;
constexpr double kSmallestError = 5e-3, kLargestError = 4.0, kLadder = 3.0;  // m/s^2
// Share of the centripetal acceleration that is felt forwards: six degrees of mounting and lean.
constexpr double kOfTurns = 0.1;
// The model is not exact, and what it leaves out lasts for more than one interval. So two intervals
// count as one.
constexpr double kEvidence = 0.5;
constexpr double kForgets_s = 60.0;  // what was learnt of the size of the error
constexpr double kMostOdds = 12.0;   // ln; no size is ever ruled out for good

// A sudden slip: how often one begins or changes, how soon it ends, and its walk in between, as a
// share of the speed per root second.
constexpr double kBegins = 0.005, kEnds = 0.05;  // 1/s
constexpr double kWalk = 0.1;
constexpr double kSurfaceLasts_s = 10.0;  // of the wheel's scale, for some metres

constexpr double kLate_s = 0.02;           // of any wheel against the IMU
constexpr double kStands_mps = 2e-3;       // StandstillSigmas
constexpr double kRolls_mps = 0.01;        // below, no slip begins or ends
constexpr double kLeast_mps = 0.05;        // slip of a slow wheel is as that of one of this speed
constexpr double kUnknownSpeed_mps = 1.0;  // by a gap of the IMU
constexpr double kDropped = 12.0;          // ln, below the likeliest

// Hypotheses whose last change is about as long ago, in intervals, become one.
constexpr int kAges[] = {1, 2, 3, 4, 6, 9, 13, 21, 40};
constexpr std::size_t kGroups = std::size(kAges) + 1, kKinds = 3;

std::size_t group_of(int age) {
  return static_cast<std::size_t>(std::upper_bound(std::begin(kAges), std::end(kAges), age) -
                                  std::begin(kAges));
}

}  // namespace

// Returns the log likelihood without its constant.
double GripFilter::Hypothesis::update(const Vector& H, double innovation, double variance) {
  const Vector PH = P * H;
  const double s = H.dot(PH) + variance;
  x += PH * (innovation / s);
  P -= PH * PH.transpose() / s;
  P = (0.5 * (P + P.transpose())).eval();
  return -0.5 * (innovation * innovation / s + std::log(s));
}

void GripFilter::Hypothesis::set(int row, double sigma) {
  x[row] = 0.0;
  P.row(row).setZero();
  P.col(row).setZero();
  P(row, row) = sigma * sigma;
}

void GripFilter::Hypothesis::jump(double sigma_mps) {
  age = 0;
  slips = true;
  set(kSlip, sigma_mps);
}

void GripFilter::Hypothesis::grip() {
  if (slips) age = 0;
  slips = false;
  set(kSlip, 0.0);
}

// Mean and covariance of the two together stay the same.
void GripFilter::Hypothesis::merge(Hypothesis other) {
  if (other.log_weight > log_weight) std::swap(*this, other);
  const double sum = log_weight + std::log1p(std::exp(other.log_weight - log_weight));
  const double share = std::exp(other.log_weight - sum);
  const Vector apart = other.x - x;
  x += share * apart;
  P = ((1 - share) * P + share * other.P + share * (1 - share) * apart * apart.transpose()).eval();
  slipped += static_cast<float>(share) * (other.slipped - slipped);
  way_m += static_cast<float>(share) * (other.way_m - way_m);
  log_weight = sum;
}

GripFilter::GripFilter(const Config& config)
    : config_(config.wheel),
      position_(config.wheel),
      lag_(static_cast<std::size_t>(config.smoother.lag * config.smoother.state_rate)) {
  for (double size = kSmallestError; size <= kLargestError; size *= kLadder) sizes_.push_back(size);
}

void GripFilter::begin(const StateResult& at) {
  const Eigen::Vector3d forwards = at.state.q_odom_body * Eigen::Vector3d::UnitX();
  Hypothesis h;
  h.x[kSpeed] = forwards.dot(at.state.v_odom);
  h.P(kSpeed, kSpeed) = forwards.dot(at.covariance.block<3, 3>(row::kV, row::kV) * forwards);
  h.P(kScale, kScale) = std::pow(SlipModel().surface, 2);
  h.P(kLeak, kLeak) = leak_of(at).variance;
  h.x[kWheelY] = position_.learnt().y_m;
  h.P(kWheelY, kWheelY) = std::pow(position_.learnt().sigma_m, 2);
  h.slipped = h.way_m = Eigen::VectorXf::Zero(static_cast<long>(lag_));
  h.log_weight = -std::log(static_cast<double>(sizes_.size()));
  for (h.size = 0; h.size < sizes_.size(); ++h.size) {
    h.P(kError, kError) = sizes_[h.size] * sizes_[h.size];
    hypotheses_.push_back(h);
  }
}

GripFilter::Leak GripFilter::leak_of(const StateResult& at) const {
  const Eigen::Vector3d forwards = at.state.q_odom_body * Eigen::Vector3d::UnitX();
  // A rotation theta of the body, in axes of the world, turns gravity.
  StateVector J = StateVector::Zero();
  J.segment<3>(row::kTheta) = kStandardGravity * forwards.cross(Eigen::Vector3d::UnitZ());
  J[row::kBa] = 1;
  return {at.state.accel_bias.x() + kStandardGravity * forwards.z(), J.dot(at.covariance * J)};
}

// The window's belief of tilt and bias changes from state to state. What a hypothesis believes of
// the leak as a whole stays, and is never less certain than the window, which sees standstills and
// all axes.
void GripFilter::follow_leak(const StateResult& at) {
  const Leak leak = leak_of(at);
  for (Hypothesis& h : hypotheses_) {
    h.x[kLeak] -= leak.mps2 - leak_mps2_;
    const double kept = std::sqrt(leak.variance / h.P(kLeak, kLeak));
    if (!(kept < 1)) continue;
    h.P.row(kLeak) *= kept;
    h.P.col(kLeak) *= kept;
  }
}

GripFilter::Step GripFilter::step_of(const StateInput& input, const StateResult& at,
                                     const GripNoise& noise) const {
  Step s;
  Eigen::Quaterniond q = at.state.q_odom_body;
  double p = 0.0, turned = 0.0, wheel_m = 0.0, way_m = 0.0;
  for (const MotionStep& step : input.steps) {
    const Eigen::Vector3d rate = step.angular_velocity - at.state.gyro_bias;
    const Eigen::Quaterniond middle = q * so3::exp(0.5 * rate * step.dt);
    const Eigen::Vector3d up = middle.conjugate() * Eigen::Vector3d(0, 0, kStandardGravity);
    const double forwards = (step.acceleration - at.state.accel_bias - up).x();
    const double density = step.bridged ? kBridgedImuNoise.accel_density : noise.accel_density;
    q = (q * so3::exp(rate * step.dt)).normalized();
    p += s.gained * step.dt + 0.5 * forwards * step.dt * step.dt;
    s.gained += forwards * step.dt;
    s.white += density * density * step.dt;
    s.dt += step.dt;
    turned += rate.z() * step.dt;
    wheel_m += step.wheel_m / at.state.wheel_scale;
    way_m += std::abs(step.wheel_m);
  }
  s.leak_mps2 = at.state.accel_bias.x() + kStandardGravity * (q * Eigen::Vector3d::UnitX()).z();
  if (s.dt <= 0) return s;
  s.behind = s.gained - p / s.dt;
  s.standing = input.standing;
  s.gap = imu_silent(input.steps);
  s.turn_rate = turned / s.dt;
  s.tilted = kStandardGravity * kStandardGravity * input.noise.gyro_density *
             input.noise.gyro_density * s.dt;
  if (!input.has_wheel) return s;
  s.wheel = wheel_m / s.dt + s.behind;
  s.turn_speed = wheel_m / s.dt * s.turn_rate;
  const double per_root_m = std::max(config_.noise, noise.wheel);
  const double variance =
      std::max(per_root_m * per_root_m * way_m + 2 * std::pow(config_.noise_floor, 2),
               std::pow(input.wheel_sigma_m, 2));
  const double late = std::hypot(kLate_s, noise.late_s) * s.gained / s.dt;
  s.wheel_variance = variance / (s.dt * s.dt) + late * late;
  return s;
}

void GripFilter::advance(const StateInput& input, const StateResult& at, const GripNoise& noise) {
  if (!config_.enabled) return;
  if (hypotheses_.empty())
    begin(at);
  else
    follow_leak(at);
  const Step step = step_of(input, at, noise);
  leak_mps2_ = step.leak_mps2;
  if (step.dt <= 0) return;
  branch(step);
  merge();
  for (Hypothesis& h : hypotheses_) {
    predict(h, step);
    weigh(h, step);
    remember(h, step);
    if (std::exchange(h.ends, false)) h.grip();
  }
  stood_ = step.standing;
  normalise();
  forget(step.dt);
  learn_position();
  intervals_.push_front({input.time - from_seconds(step.dt), input.time});
  if (intervals_.size() > lag_) intervals_.pop_back();
}

// Appends what it says of the interval.
void GripFilter::remember(Hypothesis& h, const Step& step) {
  const auto append = [](Eigen::VectorXf& past, double value) {
    std::copy_backward(past.data(), past.data() + past.size() - 1, past.data() + past.size());
    past[0] = static_cast<float>(value);
  };
  append(h.slipped, h.slips ? 1.0 : 0.0);
  append(h.way_m, (h.x[kSpeed] - step.behind) * step.dt);
}

// Adds to each hypothesis those in which the wheel begins to slip in this interval, anew or by
// another amount, or ceases to.
void GripFilter::branch(const Step& step) {
  const double by_wheel = step.wheel ? std::abs(*step.wheel) : 0.0;
  const std::size_t count = hypotheses_.size();
  for (std::size_t i = 0; i < count; ++i) {
    Hypothesis h = hypotheses_[i];
    const double speed = std::max(by_wheel, std::abs(h.x[kSpeed]));
    if (step.standing) hypotheses_[i].grip();
    if (step.standing || speed < kRolls_mps) continue;
    const double begins = kBegins * step.dt, ends = h.slips ? kEnds * step.dt : 0.0;
    hypotheses_[i].log_weight += std::log1p(-begins - ends);
    if (h.slips) {
      hypotheses_.push_back(h);
      hypotheses_.back().ends = true;
      hypotheses_.back().log_weight += std::log(ends);
    }
    h.log_weight += std::log(begins);
    h.jump(SlipModel().size * std::max(speed, kLeast_mps));
    hypotheses_.push_back(std::move(h));
  }
}

void GripFilter::predict(Hypothesis& h, const Step& step) const {
  const double dt = step.dt;
  const double kept = std::exp(-dt / kErrorLasts_s), same = std::exp(-dt / kSurfaceLasts_s);
  Matrix F = Matrix::Identity();
  F(kSpeed, kError) = F(kSpeed, kLeak) = -dt;
  F(kError, kError) = kept;
  F(kScale, kScale) = same;
  h.x = F * h.x;
  h.x[kSpeed] += step.gained;
  h.P = F * h.P * F.transpose();
  const double in_turns = kOfTurns * step.turn_speed, size = sizes_[h.size];
  h.P(kSpeed, kSpeed) += step.white + (step.gap ? kUnknownSpeed_mps * kUnknownSpeed_mps : 0.0);
  h.P(kError, kError) += (size * size + in_turns * in_turns) * (1 - kept * kept);
  h.P(kLeak, kLeak) += step.tilted;
  h.P(kScale, kScale) += std::pow(SlipModel().surface, 2) * (1 - same * same);
  if (h.slips && h.age > 0) {
    const double moving = std::max(std::abs(h.x[kSpeed]), kLeast_mps);
    h.P(kSlip, kSlip) += std::pow(kWalk * moving, 2) * dt;
    // It began within the first interval, so that one has shown only a part of it.
    if (h.age == 1) h.P(kSlip, kSlip) += std::pow(SlipModel().size * moving, 2);
  }
  ++h.age;
}

void GripFilter::weigh(Hypothesis& h, const Step& step) const {
  Vector H = Vector::Zero();
  H[kSpeed] = 1;
  if (step.standing) {
    // At rest the accelerations have no such error: nothing is learnt of its size.
    const double said = h.update(H, -h.x[kSpeed], kStands_mps * kStands_mps);
    if (!stood_) h.log_weight += kEvidence * said;
  } else if (step.wheel) {
    const double rolls = h.x[kSpeed] - h.x[kWheelY] * step.turn_rate;
    // A slip that ends within the interval has lasted for a part of it, of which nothing is known.
    const double part = h.ends ? 0.5 : 1.0, edge = h.ends ? h.x[kSlip] * h.x[kSlip] / 12 : 0.0;
    const double expected = rolls * (1 + h.x[kScale]) + part * h.x[kSlip];
    H[kSpeed] = 1 + h.x[kScale];
    H[kScale] = rolls;
    H[kSlip] = h.slips ? part : 0.0;
    H[kWheelY] = -step.turn_rate * (1 + h.x[kScale]);
    h.log_weight += kEvidence * h.update(H, *step.wheel - expected, step.wheel_variance + edge);
  }
}

// Makes one of those that differ only in an age of about the same size.
void GripFilter::merge() {
  std::vector<std::optional<Hypothesis>> groups(sizes_.size() * kKinds * kGroups);
  for (Hypothesis& h : hypotheses_) {
    const std::size_t kind = h.ends ? 2 : h.slips ? 1 : 0;
    auto& group = groups[(h.size * kKinds + kind) * kGroups + group_of(h.age)];
    if (group)
      group->merge(std::move(h));
    else
      group = std::move(h);
  }
  hypotheses_.clear();
  for (auto& group : groups)
    if (group) hypotheses_.push_back(std::move(*group));
}

// Drops the unlikely ones; the likeliest of each size stays. Then all weights sum to 1.
void GripFilter::normalise() {
  std::vector<double> most(sizes_.size(), -std::numeric_limits<double>::infinity());
  for (const Hypothesis& h : hypotheses_) most[h.size] = std::max(most[h.size], h.log_weight);
  const double best = *std::max_element(most.begin(), most.end());
  const auto unlikely = [&](const Hypothesis& h) {
    return h.log_weight < std::min(best - kDropped, most[h.size]);
  };
  hypotheses_.erase(std::remove_if(hypotheses_.begin(), hypotheses_.end(), unlikely),
                    hypotheses_.end());
  double sum = 0.0;
  for (const Hypothesis& h : hypotheses_) sum += std::exp(h.log_weight - best);
  for (Hypothesis& h : hypotheses_) h.log_weight -= best + std::log(sum);
}

void GripFilter::forget(double dt) {
  constexpr double kLeast = 1e-300;  // so that the logarithm is finite
  std::vector<double> before(sizes_.size(), kLeast), after;
  for (const Hypothesis& h : hypotheses_) before[h.size] += std::exp(h.log_weight);
  const double best = std::log(*std::max_element(before.begin(), before.end()));
  double sum = 0.0;
  for (const double weight : before) {
    const double odds = (std::log(weight) - best) * (1 - dt / kForgets_s);
    after.push_back(std::max(odds, -kMostOdds));
    sum += std::exp(after.back());
  }
  for (Hypothesis& h : hypotheses_)
    h.log_weight += after[h.size] - std::log(sum) - std::log(before[h.size]);
}

void GripFilter::learn_position() {
  double mean = 0.0, square = 0.0;
  for (const Hypothesis& h : hypotheses_) {
    const double y = h.x[kWheelY], weight = std::exp(h.log_weight);
    mean += weight * y;
    square += weight * (y * y + h.P(kWheelY, kWheelY));
  }
  position_.learn(mean, std::sqrt(std::max(0.0, square - mean * mean)));
}

void GripFilter::compare(const Displacement& radar) {
  constexpr double kCovered = 0.8;  // least share of the radar's time
  std::vector<double> seconds;      // of it, in each interval
  double all = 0.0;
  for (const Interval& each : intervals_) {
    seconds.push_back(
        std::max(0.0, to_seconds(std::min(each.to, radar.to) - std::max(each.from, radar.from))));
    all += seconds.back();
  }
  if (all < kCovered * to_seconds(radar.to - radar.from) || all <= 0) return;
  for (Hypothesis& h : hypotheses_) {
    double way = 0.0;
    for (std::size_t k = 0; k < intervals_.size(); ++k)
      way += std::abs(h.way_m[static_cast<long>(k)]) * seconds[k] /
             to_seconds(intervals_[k].to - intervals_[k].from);
    Vector H = Vector::Zero();
    H[kSpeed] = h.x[kSpeed] < 0 ? -all : all;
    h.log_weight += kEvidence * h.update(H, radar.distance_m - way, radar.sigma_m * radar.sigma_m);
  }
  normalise();
}

double GripFilter::slips() const {
  double p = 0;
  for (const Hypothesis& h : hypotheses_)
    if (h.slips) p += std::exp(h.log_weight);
  return p;
}

bool GripFilter::slipped(TimeNs from, TimeNs to) const {
  for (std::size_t k = 0; k < intervals_.size(); ++k) {
    if (intervals_[k].from >= to || intervals_[k].to <= from) continue;
    double p = 0;
    for (const Hypothesis& h : hypotheses_)
      p += std::exp(h.log_weight) * h.slipped[static_cast<long>(k)];
    if (p > 0.5) return true;
  }
  return false;
}

}  // namespace gprodom
