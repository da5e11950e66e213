// A made-up line of ground and an antenna over it, for tests of the radar parts.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "gprodom/types.h"

namespace gprodom::gpr {

// Ricker wavelets of 500 MHz from point reflectors beside a direct wave; 201 samples of 0.2 ns.
class SyntheticGround {
 public:
  static constexpr int kSamples = 201;
  static constexpr double kSampleInterval = 0.2e-9;

  explicit SyntheticGround(unsigned seed, double length = 20.0, double wave_speed = 1e8)
      : wave_speed_(wave_speed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (double x = -1.0; x < length + 1.0; x += 0.1) {
      reflectors_.push_back({x + 0.1 * uniform(random), 0.1 + 1.2 * uniform(random),
                             2000.0 * (uniform(random) - 0.5)});
    }
  }

  // Counts at `position` (m) along the line, the whole trace `delay` samples later.
  std::vector<double> trace(double position, double delay = 0.0) const {
    std::vector<double> samples(kSamples, 0.0);
    add_wavelet(samples, 12.0 + delay, 15000.0);
    for (const Reflector& r : reflectors_) {
      const double dx = position - r.position;
      if (std::abs(dx) > 0.8) continue;
      const double range = std::sqrt(dx * dx + r.depth * r.depth);
      add_wavelet(samples, 12.0 + 2.0 * range / wave_speed_ / kSampleInterval + delay,
                  r.amplitude * 0.3 / (0.3 + range * range));
    }
    return samples;
  }

 private:
  struct Reflector {
    double position, depth, amplitude;
  };

  static void add_wavelet(std::vector<double>& samples, double centre, double amplitude) {
    for (int i = 0; i < kSamples; ++i) {
      const double u = M_PI * 500e6 * (i - centre) * kSampleInterval;
      if (std::abs(u) < 5.0) samples[i] += amplitude * (1.0 - 2.0 * u * u) * std::exp(-u * u);
    }
  }

  double wave_speed_;
  std::vector<Reflector> reflectors_;
};

// A radar that drifts: white noise, a gain, a time zero and an offset of its own in each trace.
class SyntheticRadar {
 public:
  SyntheticRadar(unsigned seed, double noise, double gain = 1.0)
      : random_(seed), noise_(noise), gain_(gain) {}

  GprTrace measure(const SyntheticGround& ground, double position, double time) {
    std::normal_distribution<double> normal;
    const double delay = 0.15 * normal(random_), scale = 1.0 + 0.003 * normal(random_);
    const double offset = 100.0 * normal(random_);
    GprTrace trace;
    trace.time = from_seconds(time);
    trace.seq = ++seq_;
    trace.sample_interval_s = SyntheticGround::kSampleInterval;
    const std::vector<double> clean = ground.trace(position, delay);
    for (int i = 0; i < SyntheticGround::kSamples; ++i) {
      trace.samples.push_back(static_cast<float>(std::round(
          gain_ * (scale * clean[i] + offset * std::exp(-i / 60.0) + noise_ * normal(random_)))));
    }
    return trace;
  }

 private:
  std::mt19937 random_;
  double noise_, gain_;
  std::int64_t seq_ = 0;
};

// The trace as another antenna has it: with another gain, `late` samples later, the pulse turned.
inline GprTrace by_other_antenna(GprTrace trace, std::size_t late) {
  const std::vector<float> samples = trace.samples;
  for (std::size_t i = late + 1; i < samples.size(); ++i) {
    const float now = samples[i - late], before = samples[i - late - 1];
    trace.samples[i] = 1.6F * (0.8F * now + 0.6F * (now - before));
  }
  return trace;
}

// A trace without echoes.
inline GprTrace flat_trace(TimeNs time, std::size_t samples = 201, double interval_s = 2e-10) {
  GprTrace trace;
  trace.time = time;
  trace.sample_interval_s = interval_s;
  trace.samples.assign(samples, 1.0F);
  return trace;
}

// `count` traces as rows, the i-th at place(i) m.
template <class Place>
Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> measured(
    const SyntheticGround& ground, unsigned seed, double noise, int count, Place place) {
  SyntheticRadar radar(seed, noise);
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> traces(
      count, SyntheticGround::kSamples);
  for (int i = 0; i < count; ++i) {
    const GprTrace trace = radar.measure(ground, place(i), 0.05 * i);
    traces.row(i) = Eigen::Map<const Eigen::RowVectorXf>(trace.samples.data(), traces.cols());
  }
  return traces;
}

}  // namespace gprodom::gpr
