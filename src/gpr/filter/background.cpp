#include "gpr/filter/background.h"

#include <algorithm>
#include <stdexcept>

namespace gprodom::gpr {

RunningBackground::RunningBackground(Mode mode, int memory) : mode_(mode), memory_(memory) {
  if (memory < 1) throw std::invalid_argument("background: expected a memory of 1 trace or more");
}

void RunningBackground::reset() {
  mean_.resize(0);
  total_weight_ = 0.0;
  count_ = next_ = 0;
}

void RunningBackground::remove(float* samples, int n, float weight) {
  Eigen::Map<Eigen::VectorXf> trace(samples, n);
  if (mean_.size() != n) {
    reset();
    mean_.setZero(n);
    if (mode_ == Mode::kWindow) {
      ring_.setZero(n, memory_);
      sum_.setZero(n);
    }
  }
  if (mode_ == Mode::kRunning) {
    total_weight_ = std::min(total_weight_ + weight, static_cast<double>(memory_));
    mean_ += static_cast<float>(weight / total_weight_) * (trace - mean_);
  } else {
    count_ = std::min(count_ + 1, memory_);
    sum_ += (trace - ring_.col(next_)).cast<double>();
    ring_.col(next_) = trace;
    next_ = (next_ + 1) % memory_;
    mean_ = (sum_ / count_).cast<float>();
  }
  trace -= mean_;
}

void remove_mean_trace(Eigen::Ref<Eigen::MatrixXf> bscan) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(bscan.rows());
  for (const auto& trace : bscan.colwise()) sum += trace.cast<double>();
  bscan.colwise() -= (sum / static_cast<double>(bscan.cols())).cast<float>();
}

}  // namespace gprodom::gpr
