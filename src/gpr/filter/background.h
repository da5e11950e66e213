// Background removal: subtracts what all traces share (direct wave, ringing, flat layers) and keeps
// what differs along the track.
#pragma once

#include <Eigen/Core>

namespace gprodom::gpr {

// The mean trace so far, for a stream.
class RunningBackground {
 public:
  enum class Mode {
    kRunning,  // weighted mean of all traces; after `memory` of them, older ones fade exponentially
    kWindow,   // mean of the last `memory` traces
  };

  // memory: traces, >= 1 (std::invalid_argument otherwise).
  RunningBackground(Mode mode, int memory);

  // Adds a trace of n samples to the background and subtracts the background from it, in place.
  // weight: of this trace in the mean, 0 < weight <= 1 (kRunning only). A standing robot repeats
  // one trace; a small weight keeps the ground below it from becoming the background. A trace of
  // another length resets the background. No allocation after the first trace.
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
// (samples x traces), in place.
void remove_mean_trace(Eigen::Ref<Eigen::MatrixXf> bscan);

}  // namespace gprodom::gpr
