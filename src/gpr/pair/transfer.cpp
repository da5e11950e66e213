#include "gpr/pair/transfer.h"

#include <algorithm>
#include <complex>
#include <limits>

namespace gprodom::gpr {

namespace {

// Share of the newest columns. The transfer is followed over some hundred matches, which are tens
// of metres: time zero that drifts by 1 ns in ten minutes turns the phase by less than 0.1 rad
// meanwhile.
constexpr float kLeastRate = 0.01f;

// Largest coherence that is believed: beyond it, what the transfer does not model (the lateral
// offset, the path) is the noise.
constexpr float kMostCoherence = 0.95f;

using Frequencies =
    Eigen::Array<std::complex<float>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Frequencies as complex numbers; a row for each place.
Eigen::Map<const Frequencies> complex(const ColumnMatrix& rows) {
  return {reinterpret_cast<const std::complex<float>*>(rows.data()), rows.rows(), rows.cols() / 2};
}
Eigen::Map<Frequencies> complex(ColumnMatrix& rows) {
  return {reinterpret_cast<std::complex<float>*>(rows.data()), rows.rows(), rows.cols() / 2};
}

struct Products {
  Eigen::ArrayXf rear, front;
  Eigen::ArrayXcf cross;
  Products(const ColumnMatrix& q, const ColumnMatrix& m)
      : rear(complex(q).abs2().colwise().mean().transpose()),
        front(complex(m).abs2().colwise().mean().transpose()),
        cross((complex(q) * complex(m).conjugate()).colwise().mean().transpose()) {}
};

Eigen::ArrayXf squared_coherence(const Eigen::ArrayXcf& cross, const Eigen::ArrayXf& rear,
                                 const Eigen::ArrayXf& front) {
  return cross.abs2() / (rear * front).max(std::numeric_limits<float>::min());
}

}  // namespace

double Transfer::coherence(const ColumnMatrix& rear, const ColumnMatrix& front) {
  const Products p(rear, front);
  return squared_coherence(p.cross, p.rear, p.front).mean();
}

void Transfer::learn(const ColumnMatrix& rear, const ColumnMatrix& front) {
  const Products p(rear, front);
  const float rate = std::max(kLeastRate, 1.0f / static_cast<float>(++learnt_));
  if (learnt_ == 1) {
    rear_power_ = p.rear;
    front_power_ = p.front;
    cross_ = p.cross;
    return;
  }
  rear_power_ += rate * (p.rear - rear_power_);
  front_power_ += rate * (p.front - front_power_);
  cross_ += rate * (p.cross - cross_);
}

Eigen::ArrayXf Transfer::weights() const {
  const Eigen::ArrayXf c = squared_coherence(cross_, rear_power_, front_power_).min(kMostCoherence);
  return c / (1 - c);
}

void Transfer::apply(ColumnMatrix& rear, ColumnMatrix& front) const {
  const Eigen::ArrayXf whiten =
      (weights() / rear_power_.max(std::numeric_limits<float>::min())).sqrt();
  const Eigen::ArrayXcf turn =
      cross_ / front_power_.max(std::numeric_limits<float>::min()) * whiten;
  complex(rear).rowwise() *= whiten.cast<std::complex<float>>().transpose();
  complex(front).rowwise() *= turn.transpose();
}

}  // namespace gprodom::gpr
