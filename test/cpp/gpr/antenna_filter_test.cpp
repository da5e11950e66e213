#include "gpr/pair/antenna_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr double kFar = 10.0;  // m, of the ground that is learnt from

// Antenna 1 has another gain, a time zero 1.4 ns later, and another pulse.
GprTrace as_other(GprTrace trace) {
  trace = by_other_antenna(std::move(trace), 7);
  trace.antenna_id = 1;
  return trace;
}

// What is left of a trace without the direct wave, which all traces have.
Eigen::VectorXf echoes(const GprTrace& trace, const GprTrace& other) {
  const auto n = static_cast<Eigen::Index>(trace.samples.size());
  return Eigen::Map<const Eigen::VectorXf>(trace.samples.data(), n) -
         Eigen::Map<const Eigen::VectorXf>(other.samples.data(), n);
}

class TwoAntennas : public ::testing::Test {
 protected:
  void learn(int traces) {
    for (int i = 0; i < traces; ++i) {
      const double x = kFar * i / traces;
      filter_.learn(radar_.measure(ground_, x, 0.05 * i));
      filter_.learn(as_other(radar_.measure(ground_, x - 0.3, 0.05 * i)));
    }
  }

  // Of antenna 0, without the drift of a receiver.
  GprTrace clean(double x) {
    GprTrace trace = radar_.measure(ground_, x, 100.0);
    const std::vector<double> samples = ground_.trace(x);
    trace.samples.assign(samples.begin(), samples.end());
    return trace;
  }

  // Correlation of the echoes of both antennas at places that were not learnt from.
  double likeness() {
    double product = 0.0, front = 0.0, rear = 0.0;
    const auto by_rear = [&](double x) { return filter_.as_of(0, as_other(clean(x))); };
    for (double x = kFar + 1.0; x < 18.0; x += 0.25) {
      const Eigen::VectorXf q = echoes(by_rear(x), by_rear(x + 0.6));
      const Eigen::VectorXf m = echoes(clean(x), clean(x + 0.6));
      product += q.dot(m);
      front += m.squaredNorm();
      rear += q.squaredNorm();
    }
    return product / std::sqrt(front * rear);
  }

  AntennaFilter filter_{GprFilterConfig{}};
  SyntheticGround ground_{5};
  SyntheticRadar radar_{1, 60.0};
};

TEST_F(TwoAntennas, TracesOfOneBecomeThoseOfTheOther) {
  EXPECT_LT(likeness(), 0.3);
  learn(400);
  EXPECT_GT(likeness(), 0.85);
}

TEST_F(TwoAntennas, NothingIsChangedBeforeBothAreKnown) {
  learn(50);
  const GprTrace trace = as_other(radar_.measure(ground_, 5.0, 100.0));
  EXPECT_EQ(filter_.as_of(0, trace).samples, trace.samples);
  learn(400);
  EXPECT_NE(filter_.as_of(0, trace).samples, trace.samples);
  EXPECT_EQ(filter_.as_of(1, trace).samples, trace.samples) << "it is of that antenna";
  EXPECT_EQ(filter_.as_of(7, trace).samples, trace.samples) << "there is no such antenna";
  GprTrace shorter = trace;
  shorter.samples.resize(100);
  EXPECT_EQ(filter_.as_of(0, shorter).samples, shorter.samples) << "of another setting";
}

// A radar that is switched off sends zeros.
TEST_F(TwoAntennas, TracesWithoutASignalGiveNothingThatIsNotFinite) {
  GprTrace dead = radar_.measure(ground_, 0.0, 0.0);
  std::fill(dead.samples.begin(), dead.samples.end(), 0.0F);
  for (int antenna : {0, 1}) {
    dead.antenna_id = antenna;
    for (int i = 0; i < 300; ++i) filter_.learn(dead);
  }
  const GprTrace trace = as_other(radar_.measure(ground_, 5.0, 100.0));
  for (const float sample : filter_.as_of(0, trace).samples) EXPECT_TRUE(std::isfinite(sample));
}

}  // namespace
}  // namespace gprodom::gpr
