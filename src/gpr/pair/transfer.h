// What makes the traces of one antenna those of another over the same ground: a complex factor for
// each frequency (gain, time zero, phase and shape of the pulse), learnt from columns of the same
// places and followed, and how much the two have in common.
#pragma once

#include <Eigen/Core>

#include "gpr/pair/columns.h"

namespace gprodom::gpr {

class Transfer {
 public:
  // rear, front: columns of the same places, less their mean.
  void learn(const ColumnMatrix& rear, const ColumnMatrix& front);
  void clear() { learnt_ = 0; }
  int learnt() const { return learnt_; }

  // In place: makes the columns of the front antenna what the rear one would have seen there, and
  // weights both so that each frequency counts by its signal-to-noise ratio.
  void apply(ColumnMatrix& rear, ColumnMatrix& front) const;

  // Signal-to-noise ratio of each frequency, all blocks: coherence over one less coherence.
  Eigen::ArrayXf weights() const;

  // Mean squared coherence of the columns by themselves, over all frequencies. It does not depend
  // on the transfer.
  static double coherence(const ColumnMatrix& rear, const ColumnMatrix& front);

 private:
  Eigen::ArrayXf rear_power_, front_power_;
  Eigen::ArrayXcf cross_;  // mean of rear times the conjugate of front
  int learnt_ = 0;
};

}  // namespace gprodom::gpr
