#include "estimation/fixed_lag_smoother.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "estimation/block_products.h"

namespace gprodom {

namespace {

// Typical sizes of the error's rows. Eliminating in these units keeps the pivots within a few
// orders of magnitude of each other.
StateVector row_units() {
  StateVector u;
  u << Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(1e-2),
      Eigen::Vector3d::Constant(1e-2), Eigen::Vector3d::Constant(1e-4),
      Eigen::Vector3d::Constant(1e-2), 1e-2;
  return u;
}

// Cauchy: rho(r) = c^2/2 log(1 + (r/c)^2), and its weight rho'(r) / r.
double robust_cost(double r, double c) {
  return c > 0 ? 0.5 * c * c * std::log1p(r * r / (c * c)) : 0.5 * r * r;
}
double robust_weight(double r, double c) { return c > 0 ? 1 / (1 + r * r / (c * c)) : 1.0; }

double total_cost(const Factor& factor, const Residual& r) {
  double sum = 0;
  for (int i = 0; i < r.size(); ++i) sum += robust_cost(r[i], factor.robust_threshold(i));
  return sum;
}

// Heading and position, in the order of common_information().
constexpr int kCommonRows[] = {row::kTheta + 2, row::kP, row::kP + 1, row::kP + 2};

constexpr double kRounding = 1.1;  // of an information

// Steps beyond the cap while none is accepted, each with ten times the damping of the last.
constexpr int kMoreDamping = 8;

// Columns in row units.
void scale_columns(Jacobian& J) {
  static const StateVector units = row_units();
  for (int i = 0; i < J.rows(); ++i) J.row(i).array() *= units.transpose().array();
}

// A Jacobian and where it is not zero: a factor knows nothing of a good part of a state.
struct Known {
  const Jacobian& J;
  ColumnGroups columns;
  explicit Known(const Jacobian& jacobian)
      : J(jacobian), columns(column_groups(J.data(), static_cast<int>(J.rows()))) {}
};

// C += A^T B.
template <Part kPart>
void add_product(const Known& A, const Known& B, StateMatrix& C) {
  add_outer_products<1, kPart>(A.J.data(), B.J.data(), static_cast<int>(A.J.rows()), C, A.columns,
                               B.columns);
}

void weight_rows(const Factor& factor, Residual& r, Jacobian& Ja, Jacobian& Jb) {
  for (int i = 0; i < r.size(); ++i) {
    const double c = factor.robust_threshold(i);
    if (c <= 0) continue;
    const double w = std::sqrt(robust_weight(r[i], c));
    r[i] *= w;
    Ja.row(i) *= w;
    Jb.row(i) *= w;
  }
}

}  // namespace

FixedLagSmoother::FixedLagSmoother(const SmootherOptions& options, const NavState& first,
                                   MarginalPrior prior)
    : options_(options), states_{first}, prior_(std::move(prior)) {}

// The errors that nothing measures are the same directions for every state (nav_state.h).
Eigen::Vector4d FixedLagSmoother::common_information(const MarginalPrior& prior) {
  Eigen::Vector4d information;
  for (int i = 0; i < 4; ++i) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(prior.A.rows());
    for (int k = 0; k < prior.states(); ++k) sum += prior.A.col(k * kStateDim + kCommonRows[i]);
    information[i] = sum.squaredNorm();
  }
  return information;
}

// What is known of the newest state's heading and place cannot be more than of all of the window's
// in common, and that is the prior's.
bool FixedLagSmoother::claims_too_much() const {
  const Eigen::Vector4d known = common_information(prior_);
  static const StateVector units = row_units();
  const auto L = block(L_, g_.size() - 1, g_.size() - 1).triangularView<Eigen::Lower>();
  for (int i = 0; i < 4; ++i) {
    const StateVector direction = StateVector::Unit(kCommonRows[i]) / units[kCommonRows[i]];
    if ((L.transpose() * direction).squaredNorm() > kRounding * known[i]) return true;
  }
  return false;
}

FixedLagSmoother::StateId FixedLagSmoother::add_state(const NavState& predicted) {
  if (predicted.time <= newest().time)
    throw std::invalid_argument("FixedLagSmoother: a state must be newer than the last");
  states_.push_back(predicted);
  return newest_id();
}

bool FixedLagSmoother::add_factor(StateId a, StateId b, std::shared_ptr<const Factor> factor) {
  if (a < oldest_id() || b > newest_id() || a >= b) return false;
  const auto place = std::upper_bound(links_.begin(), links_.end(), a,
                                      [](StateId id, const Link& link) { return id < link.a; });
  links_.insert(place, Link{a, b, std::move(factor)});
  return true;
}

double FixedLagSmoother::cost(const States& x) const {
  Eigen::VectorXd rp;
  prior_.evaluate(x.data(), rp, nullptr);
  double sum = 0.5 * rp.squaredNorm();
  Residual r;
  for (const Link& link : links_) {
    link.factor->evaluate(x[index(link.a)], x[index(link.b)], r, nullptr, nullptr);
    sum += total_cost(*link.factor, r);
  }
  return sum;
}

double FixedLagSmoother::linearise(const States& x) {
  bandwidth_ = std::max<size_t>(1, prior_.states() > 0 ? prior_.states() - 1 : 0);
  first_.assign(x.size(), 0);
  for (size_t i = prior_.states(); i < x.size(); ++i) first_[i] = i;
  for (const Link& link : links_) {
    bandwidth_ = std::max(bandwidth_, static_cast<size_t>(link.b - link.a));
    first_[index(link.b)] = std::min(first_[index(link.b)], index(link.a));
  }
  H_.resize(x.size() * (bandwidth_ + 1));
  L_.resize(H_.size());
  for (size_t i = 0; i < x.size(); ++i)
    for (size_t j = first_[i]; j <= i; ++j) block(H_, i, j).setZero();
  g_.assign(x.size(), StateVector::Zero());

  Eigen::VectorXd rp;
  Eigen::MatrixXd Jp;
  prior_.evaluate(x.data(), rp, &Jp);
  double sum = 0.5 * rp.squaredNorm();
  static const StateVector units = row_units();
  for (int i = 0; i < prior_.states(); ++i)
    Jp.middleCols<kStateDim>(i * kStateDim) *= units.asDiagonal();
  for (int i = 0; i < prior_.states(); ++i) {
    const auto Ji = Jp.middleCols<kStateDim>(i * kStateDim);
    g_[i].noalias() += Ji.transpose() * rp;
    for (int j = 0; j <= i; ++j)
      block(H_, i, j).noalias() += Ji.transpose() * Jp.middleCols<kStateDim>(j * kStateDim);
  }

  Residual r;
  Jacobian Ja, Jb;
  for (const Link& link : links_) {
    const size_t a = index(link.a), b = index(link.b);
    link.factor->evaluate(x[a], x[b], r, &Ja, &Jb);
    sum += total_cost(*link.factor, r);
    weight_rows(*link.factor, r, Ja, Jb);
    scale_columns(Ja);
    scale_columns(Jb);
    const Known A(Ja), B(Jb);
    add_product<Part::kLower>(A, A, block(H_, a, a));
    add_product<Part::kAll>(B, A, block(H_, b, a));
    add_product<Part::kLower>(B, B, block(H_, b, b));
    g_[a].noalias() += Ja.transpose().lazyProduct(r);
    g_[b].noalias() += Jb.transpose().lazyProduct(r);
  }
  return sum;
}

// Left-looking block Cholesky of the envelope, oldest state first: a row fills up from its first
// block on, and nowhere else.
bool FixedLagSmoother::eliminate(double damping) {
  const size_t n = g_.size();
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = first_[i]; j <= i; ++j) {
      StateMatrix& Lij = block(L_, i, j);
      Lij = block(H_, i, j);
      if (i == j) Lij.diagonal() *= 1 + damping;
      const size_t shared = std::max(first_[i], first_[j]);
      for (size_t k = shared; k < j; ++k)
        i == j ? subtract_product<Part::kLower>(block(L_, i, k), block(L_, i, k), Lij)
               : subtract_product<Part::kAll>(block(L_, i, k), block(L_, j, k), Lij);
      if (j < i) {
        solve_transposed_on_the_right(block(L_, j, j), Lij);
      } else {
        const Eigen::LLT<StateMatrix> llt(Lij);
        if (llt.info() != Eigen::Success) return false;
        Lij = llt.matrixL();
      }
    }
  }
  return true;
}

double FixedLagSmoother::solve_step(std::vector<StateVector>& step) const {
  const size_t n = g_.size();
  step.resize(n);
  double decrease = 0;
  for (size_t i = 0; i < n; ++i) {
    StateVector y = -g_[i];
    for (size_t k = first_[i]; k < i; ++k) y.noalias() -= block(L_, i, k).lazyProduct(step[k]);
    step[i] = block(L_, i, i).triangularView<Eigen::Lower>().solve(y);
    decrease += 0.5 * step[i].squaredNorm();  // half |L^-1 g|^2
  }
  static const StateVector units = row_units();
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < std::min(n, i + bandwidth_ + 1); ++k)
      if (first_[k] <= i) step[i].noalias() -= block(L_, k, i).transpose().lazyProduct(step[k]);
    block(L_, i, i).transpose().triangularView<Eigen::Upper>().solveInPlace(step[i]);
  }
  for (auto& s : step) s.array() *= units.array();
  return decrease;
}

// The states in a frame whose origin lies `by` further on, and the prior in the chart there, which
// turns about that origin: rho there is rho + theta x by.
void FixedLagSmoother::shift_origin(const Eigen::Vector3d& by) {
  for (NavState& x : states_) x.p_odom -= by;
  for (NavState& x : prior_.x0) x.p_odom -= by;
  for (int i = 0; i < prior_.states(); ++i) {
    const Eigen::MatrixXd turned = prior_.A.middleCols<3>(i * kStateDim + row::kP) * so3::skew(by);
    prior_.A.middleCols<3>(i * kStateDim + row::kTheta) += turned;
  }
}

// Far from the origin a small turn of one state against the next is a long way, to second order
// further than wheel and IMU allow. So the solution is made where the robot is.
SolveSummary FixedLagSmoother::solve() {
  const Eigen::Vector3d here = newest().p_odom;
  shift_origin(here);
  const SolveSummary summary = solve_at_origin();
  shift_origin(-here);
  if (summary.usable) {
    StateMatrix to_odom = StateMatrix::Identity();
    to_odom.block<3, 3>(row::kP, row::kTheta) = so3::skew(here);
    newest_covariance_ = (to_odom * newest_covariance_ * to_odom.transpose()).eval();
  }
  return summary;
}

SolveSummary FixedLagSmoother::solve_at_origin() {
  SolveSummary summary;
  std::vector<StateVector> step;
  States trial(states_.size());
  double damping = 0, damping_of_factor = 0, expected = 0;
  summary.cost = linearise(states_);
  // Where every step so far was refused, more damping is tried: a failure costs the whole window.
  while (summary.steps < options_.max_iterations ||
         (!summary.usable && summary.steps < options_.max_iterations + kMoreDamping)) {
    if (!std::isfinite(summary.cost)) return summary;
    if (!eliminate(damping)) {
      damping = std::max(1e-6, 10 * damping);
      ++summary.steps;
      continue;
    }
    damping_of_factor = damping;
    expected = solve_step(step);
    std::transform(states_.begin(), states_.end(), step.begin(), trial.begin(), retract);
    const double trial_cost = cost(trial);
    ++summary.steps;
    // Rounding of a large cost is no reason to refuse a step.
    if (std::isfinite(trial_cost) && trial_cost <= summary.cost * (1 + 1e-12) + 1e-9) {
      ++summary.accepted;
      states_.swap(trial);
      prior_.move_to(states_.data());
      summary.cost = trial_cost;
      summary.usable = true;
      damping = 0;
      if (expected < options_.convergence || summary.steps >= options_.max_iterations) break;
      linearise(states_);
    } else {
      damping = std::max(1e-6, 10 * damping);
    }
  }
  if (!summary.usable) return summary;
  // Damping is no knowledge: the covariance comes from the equations without it, also where the
  // last step that was accepted needed some.
  if (damping_of_factor > 0 && !eliminate(0)) return summary;
  static const StateVector units = row_units();
  const StateMatrix L_inverse = block(L_, g_.size() - 1, g_.size() - 1)
                                    .triangularView<Eigen::Lower>()
                                    .solve(StateMatrix::Identity());
  const StateMatrix inverse =
      units.asDiagonal() * (L_inverse.transpose() * L_inverse) * units.asDiagonal();
  newest_covariance_ = 0.5 * (inverse + inverse.transpose());
  summary.unfounded = std::exchange(prior_gained_, false) || claims_too_much();
  return summary;
}

void FixedLagSmoother::marginalise() {
  const TimeNs horizon = newest().time - from_seconds(options_.lag_s);
  while (states_.size() > 1 && states_.front().time < horizon) {
    const Eigen::Vector4d known = common_information(prior_);
    // The prior on the states 1..n that the oldest is tied to, and the rows that go into it.
    const auto end = std::find_if(links_.begin(), links_.end(),
                                  [this](const Link& link) { return link.a > first_id_; });
    Eigen::Index rows = prior_.A.rows();
    size_t held = std::max(2, prior_.states());
    for (auto link = links_.begin(); link != end; ++link) {
      rows += link->factor->dimension();
      held = std::max(held, index(link->b) + 1);
    }

    // The prior keeps the Jacobian it was made with (its first estimate): exact null space.
    Eigen::VectorXd r(rows), rp;
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, held * kStateDim);
    prior_.evaluate(states_.data(), rp, nullptr);
    r.head(rp.size()) = rp;
    J.topLeftCorner(prior_.A.rows(), prior_.A.cols()) = prior_.A;
    Eigen::Index at = rp.size();
    Residual rf;
    Jacobian Ja, Jb;
    for (auto link = links_.begin(); link != end; ++link) {
      const size_t b = index(link->b);
      link->factor->evaluate(states_[0], states_[b], rf, &Ja, &Jb);
      weight_rows(*link->factor, rf, Ja, Jb);
      r.segment(at, rf.size()) = rf;
      J.block(at, 0, rf.size(), kStateDim) = Ja;
      J.block(at, b * kStateDim, rf.size(), kStateDim) = Jb;
      at += rf.size();
    }
    eliminate_first_state(std::move(J), std::move(r), prior_.A, prior_.b);
    prior_.x0.assign(states_.begin() + 1, states_.begin() + static_cast<long>(held));
    const Eigen::Array4d now_known = common_information(prior_);
    prior_gained_ |= (now_known > kRounding * known.array()).any();
    links_.erase(links_.begin(), end);
    states_.erase(states_.begin());
    ++first_id_;
  }
}

}  // namespace gprodom
