#include "estimation/window.h"

#include <algorithm>
#include <utility>

namespace gprodom {

double window_cost(const Window& window) {
  const std::vector<NavState>& x = window.states;
  Eigen::VectorXd rp;
  window.prior.evaluate(x.data(), rp, nullptr);
  double sum = 0.5 * rp.squaredNorm();
  Residual r;
  for (const Window::Link& link : window.links) {
    link.factor->evaluate(x[window.index(link.a)], x[window.index(link.b)], r, nullptr, nullptr);
    sum += robust_cost(*link.factor, r);
  }
  return sum;
}

bool gained(const Eigen::Vector4d& before, const Eigen::Vector4d& now) {
  constexpr double kRounding = 1.1;  // of an information
  return (now.array() > kRounding * before.array()).any();
}

void shift_origin(Window& window, const Eigen::Vector3d& by) {
  *window.origin += by;
  for (NavState& x : window.states) x.p_odom -= by;
  window.prior.shift_origin(by);
}

bool marginalise_oldest(Window& window) {
  // The prior on the states 1..n that the oldest is tied to, and the rows that go into it.
  const auto end = std::find_if(window.links.begin(), window.links.end(),
                                [&](const Window::Link& link) { return link.a > window.first_id; });
  MarginalPrior& prior = window.prior;
  const Eigen::Vector4d known = prior.common_information();
  bool place_measured = false;
  Eigen::Index rows = prior.A.rows();
  size_t held = std::max(2, prior.states());
  for (auto link = window.links.begin(); link != end; ++link) {
    rows += link->factor->dimension();
    place_measured |= link->factor->measures_place();
    held = std::max(held, window.index(link->b) + 1);
  }

  // The prior keeps the Jacobian it was made with (its first estimate): exact null space.
  Eigen::VectorXd r(rows), rp;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, held * kStateDim);
  prior.evaluate(window.states.data(), rp, nullptr);
  r.head(rp.size()) = rp;
  J.topLeftCorner(prior.A.rows(), prior.A.cols()) = prior.A;
  Eigen::Index at = rp.size();
  Residual rf;
  Jacobian Ja, Jb;
  for (auto link = window.links.begin(); link != end; ++link) {
    const size_t b = window.index(link->b);
    link->factor->evaluate(window.states[0], window.states[b], rf, &Ja, &Jb);
    weight_rows(*link->factor, rf, Ja, Jb);
    r.segment(at, rf.size()) = rf;
    J.block(at, 0, rf.size(), kStateDim) = Ja;
    J.block(at, b * kStateDim, rf.size(), kStateDim) = Jb;
    at += rf.size();
  }
  eliminate_first_state(std::move(J), std::move(r), prior.A, prior.b);
  prior.x0.assign(window.states.begin() + 1, window.states.begin() + static_cast<long>(held));
  window.links.erase(window.links.begin(), end);
  window.states.erase(window.states.begin());
  ++window.first_id;
  return !place_measured && gained(known, prior.common_information());
}

}  // namespace gprodom
