// What a soak measures beside the estimator: processor time, memory, and a yardstick of the
// machine.
#pragma once

#include <unistd.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace gprodom {

inline double processor_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

inline std::int64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

// The same small computation of the smoother's kind, about half a millisecond, again and again.
// What else the machine does changes its time as it changes the estimator's.
class Yardstick {
 public:
  void measure() {
    const double begin = processor_s();
    if (computed() < 0) throw std::logic_error("the yardstick's result is used");
    spent_s_ += processor_s() - begin;
    ++times_;
  }

  double spent_s() const { return spent_s_; }  // in all

  // Mean processor time since the last call.
  double take_mean_s() {
    const double mean = (spent_s_ - before_s_) / std::max(1, times_);
    before_s_ = spent_s_;
    times_ = 0;
    return mean;
  }

 private:
  static double computed() {
    using Block = Eigen::Matrix<double, 16, 16>;
    Block H = 20 * Block::Identity() + Block::Ones();
    for (int i = 0; i < 150; ++i) {
      const Block L = H.llt().matrixL();
      H = 0.5 * (H + L * L.transpose());
    }
    return H(3, 5);
  }

  double spent_s_ = 0.0, before_s_ = 0.0;
  int times_ = 0;
};

}  // namespace gprodom
