// Background removal: what all traces share (direct wave, ringing, flat layers) is subtracted, what
// differs along the track stays.
#pragma once

#include <Eigen/Core>

namespace gprodom::gpr {

// The mean trace so far, for a stream.
class RunningBackground {
 public:
  enum class Mode {
    kRunning,  // weighted mean of all traces; beyond `memory` of them old ones fade exponentially
    kWindow,   // mean of the last `memory` traces
  };

  // memory: traces, >= 1 (std::invalid_argument otherwise).
  RunningBackground(Mode mode, int memory);

  // Takes in a trace of n samples and subtracts the background from it, in place. weight: of this
  // trace in the mean, 0 < weight <= 1. A robot that stands adds the same trace again and again:
  // with a small weight it does not make the ground below it the background (kRunning only).
  // A trace of another length starts afresh. No allocation after the first trace.
  void remove(float* samples, int n, float weight = 1.0f);

  // The mean trace; empty before the first.
  const Eigen::VectorXf& mean() const { return mean_; }
  void reset();

 private:
  Mode mode_;
  int memory_;
  Eigen::VectorXf mean_;
  double total_weight_ = 0.0;
  // kWindow: a ring of traces (samples x memory) and their sum, in double so that it does not
  // drift.
  Eigen::MatrixXf ring_;
  Eigen::VectorXd sum_;
  int count_ = 0, next_ = 0;
};

// The same for a whole sequence at once: subtracts the mean over the columns of `bscan`
// (samples x traces), in place, leaving out columns whose `use` is 0 (nullptr: all count).
void remove_mean_trace(Eigen::Ref<Eigen::MatrixXf> bscan, const unsigned char* use = nullptr);

}  // namespace gprodom::gpr
