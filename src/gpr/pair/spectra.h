// A trace as spectra of parts of its depth: what two antennas have in common, whatever gain, time
// zero and pulse each of them has, since these multiply each frequency by a factor.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/trace_format.h"
#include "gprodom/config.h"

namespace gprodom::gpr {

constexpr int kDepthBlocks = 4;

class Spectra {
 public:
  // format: of the traces. The antenna's band gives the frequencies.
  Spectra(const TraceFormat& format, const GprFilterConfig& band);

  int frequencies() const { return frequencies_; }  // of a block

  // Length of the result: real and imaginary part of each frequency, block after block.
  int size() const { return 2 * kDepthBlocks * frequencies_; }

  Eigen::VectorXf of(const std::vector<float>& samples) const;

 private:
  int frequencies_ = 0;
  Eigen::Index length_ = 0;          // samples of a block
  std::vector<Eigen::Index> begin_;  // of each block
  Eigen::MatrixXf transform_;        // (2 frequencies, length)
};

}  // namespace gprodom::gpr
