#include "gpr/motion/stationarity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "gpr/front_end_factory.h"
#include "gpr/motion/window_statistics.h"
#include "gpr/synthetic_ground.h"
#include "gprodom/error.h"
#include "support/noise.h"

namespace gprodom::gpr {
namespace {

constexpr double kWindow = 0.6;
constexpr double kTraceStep = 0.05;

// Speed profile: stands to 3 s, speeds up at 0.5 m/s^2 to 0.4 m/s, stops from 12 to 15 s, goes
// back.
double position_at(double t) {
  const auto ramp = [](double since, double duration) {  // distance of a trapezoid, 0.8 s ramps
    if (since <= 0.0) return 0.0;
    if (since >= duration) return 0.4 * (duration - 0.8);
    if (since < 0.8) return 0.25 * since * since;
    const double left = duration - since;
    if (left < 0.8) return 0.4 * (duration - 0.8) - 0.25 * left * left;
    return 0.4 * (since - 0.4);
  };
  return 1.0 + ramp(t - 3.0, 9.0) - ramp(t - 15.0, 5.0);
}

struct Scene {
  double start = 0.0, end = 23.0;
  double noise = 60.0, gain = 1.0;
  double step = kTraceStep;
  std::function<double(double)> position = position_at;
  std::function<void(int, GprTrace&)> spoil = [](int, GprTrace&) {};
};

// The claims of a run with a tick every 0.1 s, and the sights where they are asked for; checks what
// every claim must hold.
std::vector<Standstill> run(const Scene& scene, StationarityFrontEnd& front_end,
                            std::vector<Sight>* sights = nullptr) {
  const SyntheticGround ground(3);
  SyntheticRadar radar(11, scene.noise, scene.gain);
  std::vector<Standstill> claims;
  double tick = scene.start;
  const int count = static_cast<int>((scene.end - scene.start) / scene.step);
  for (int i = 0; i < count; ++i) {
    const double t = scene.start + i * scene.step;
    for (; tick < t; tick += 0.1) {
      for (const Finding& finding : front_end.tick(from_seconds(tick))) {
        if (const auto* sight = std::get_if<Sight>(&finding)) {
          if (sights) sights->push_back(*sight);
          continue;
        }
        const auto& claim = std::get<Standstill>(finding);
        EXPECT_GT(claim.sigma_m, 0.0);
        EXPECT_LT(claim.from, claim.to);
        EXPECT_LE(claim.to, from_seconds(tick));
        claims.push_back(claim);
      }
    }
    GprTrace trace = radar.measure(ground, scene.position(t), t);
    scene.spoil(i, trace);
    front_end.add_trace(trace);
  }
  return claims;
}

bool claimed(const std::vector<Standstill>& claims, double t) {
  return std::any_of(claims.begin(), claims.end(), [t](const Standstill& d) {
    return d.from <= from_seconds(t) && from_seconds(t) <= d.to;
  });
}

// Fraction claimed of the standstills (0.2 s at their edges left out, and those before `known`),
// and the farthest that the antenna moved within a claim.
struct Outcome {
  double recall = 0.0, unseen_motion = 0.0;
};
Outcome judge(const std::vector<Standstill>& claims, double known = 0.0, double end = 23.0) {
  Outcome outcome;
  int standing = 0, found = 0;
  for (double t = known; t < end - 0.6; t += 0.01) {
    const bool stands = (t > 0.0 && t < 2.8) || (t > 12.2 && t < 14.8) || t > 20.2;
    if (!stands) continue;
    ++standing;
    found += claimed(claims, t) ? 1 : 0;
  }
  outcome.recall = static_cast<double>(found) / standing;
  for (const Standstill& d : claims) {
    for (double t = to_seconds(d.from); t <= to_seconds(d.to); t += 0.01) {
      outcome.unseen_motion = std::max(outcome.unseen_motion,
                                       std::abs(position_at(t) - position_at(to_seconds(d.from))));
    }
  }
  return outcome;
}

Outcome outcome_of(const Scene& scene) {
  StationarityFrontEnd front_end(kWindow);
  return judge(run(scene, front_end), scene.start);
}

// Over the length of a window the antenna creeps by less than can be seen, and is claimed to stand;
// over seconds the traces become different, and the claims do not say that it stood for so long.
TEST(Stationarity, ComparesTracesOverLongerThanItsWindow) {
  constexpr double kCreep_mps = 1.5e-3;
  Scene creeping;
  creeping.position = [](double t) { return 1.0 + kCreep_mps * std::max(0.0, t - 5.0); };
  StationarityFrontEnd front_end(kWindow);
  double claimed_s = 0.0, longest_m = 0.0, longest_at_rest_s = 0.0;
  for (const Standstill& d : run(creeping, front_end)) {
    EXPECT_GT(d.since, 0);
    const double since = to_seconds(d.since), to = to_seconds(d.to);
    if (since > 5.0) {
      claimed_s += to - to_seconds(d.from);
      longest_m = std::max(longest_m, kCreep_mps * (to - since));
    } else if (to < 5.0) {
      longest_at_rest_s = std::max(longest_at_rest_s, to - since);
    }
  }
  EXPECT_GT(longest_at_rest_s, 3.0);
  EXPECT_GT(claimed_s, 1.0);
  EXPECT_LT(longest_m, 0.02);
}

// The noise of smoothed traces: 6/16 of that of the samples.
TEST(Stationarity, ReportsStandstillsOnlyAndLearnsTheNoiseLevelWhateverTheGain) {
  for (const double gain : {0.05, 1.0, 40.0}) {
    Scene scene;
    scene.gain = gain;
    StationarityFrontEnd front_end(kWindow);
    const Outcome outcome = judge(run(scene, front_end));
    EXPECT_GT(outcome.recall, 0.95) << gain;
    EXPECT_LT(outcome.unseen_motion, 2e-3) << gain;
    const double expected = 60.0 * gain * std::sqrt(6.0 / 16.0);
    EXPECT_NEAR(std::sqrt(front_end.noise_variance()), expected, 0.1 * expected) << gain;
  }
}

TEST(Stationarity, FindsStandstillsAfterAMovingStart) {
  Scene scene;
  scene.start = 5.0;
  const Outcome outcome = outcome_of(scene);
  EXPECT_GT(outcome.recall, 0.95);
  EXPECT_LT(outcome.unseen_motion, 2e-3);
}

// Noise that grows threefold, as after a change of gain, is learned anew at the next long
// standstill.
TEST(Stationarity, FollowsARisingNoiseLevel) {
  Scene scene;
  scene.end = 30.0;
  Noise noise(5);
  scene.spoil = [&](int i, GprTrace& trace) {
    if (i * kTraceStep < 8.0) return;
    for (float& sample : trace.samples) sample += static_cast<float>(noise(170.0));
  };
  StationarityFrontEnd front_end(kWindow);
  const std::vector<Standstill> claims = run(scene, front_end);
  EXPECT_LT(judge(claims).unseen_motion, 4e-3);
  EXPECT_TRUE(claimed(claims, 28.0));
}

TEST(Stationarity, ReportsNothingForADeadAntenna) {
  Scene scene;
  Noise noise(5);
  scene.spoil = [&](int i, GprTrace& trace) {
    for (float& sample : trace.samples)
      sample = i % 400 < 200 ? static_cast<float>(noise(60.0)) : 0.0f;
  };
  StationarityFrontEnd front_end(kWindow);
  EXPECT_TRUE(run(scene, front_end).empty());
}

TEST(Stationarity, LeavesOutASpikedTrace) {
  Scene scene;
  scene.spoil = [](int i, GprTrace& trace) {
    if (i % 40 != 13) return;
    for (int k = 40; k < 120; ++k) trace.samples[k] += k % 5 == 0 ? 8000.0f : -3000.0f;
  };
  const Outcome outcome = outcome_of(scene);
  EXPECT_GT(outcome.recall, 0.9);
  EXPECT_LT(outcome.unseen_motion, 2e-3);
}

TEST(Stationarity, WorksAtOtherTraceRates) {
  for (const double step : {0.1, 0.01}) {
    Scene scene;
    scene.step = step;
    const Outcome outcome = outcome_of(scene);
    EXPECT_GT(outcome.recall, 0.9) << step;
    EXPECT_LT(outcome.unseen_motion, 4e-3) << step;
  }
}

// Stands for 6 s, and then goes on for 10 s at a speed (m/s).
Scene go_on_at(double speed, double noise) {
  Scene scene;
  scene.end = 16.0;
  scene.noise = noise;
  scene.position = [speed](double t) { return 1.0 + speed * std::max(0.0, t - 6.0); };
  return scene;
}

// The slowest speed that is seen, from a drive at a speed; the logarithms' mean.
double least_speed(double speed, double noise) {
  StationarityFrontEnd front_end(kWindow);
  std::vector<Sight> sights;
  run(go_on_at(speed, noise), front_end, &sights);
  double sum = 0.0;
  int count = 0;
  for (const Sight& sight : sights) {
    if (sight.from < from_seconds(6.0)) continue;
    sum += std::log(speed / sight.times_least);
    ++count;
  }
  EXPECT_GT(count, 10);
  return std::exp(sum / count);
}

TEST(Stationarity, SightIsTheLeastVisibleSpeedAtAnySpeed) {
  for (const double noise : {20.0, 60.0}) {
    const double least = least_speed(0.4, noise);
    EXPECT_NEAR(least_speed(0.2, noise) / least, 1.0, 0.3) << noise;
    const auto seen = [&](double times) {
      StationarityFrontEnd front_end(kWindow);
      const auto claims = run(go_on_at(times * least, noise), front_end);
      double unseen = 0.0;
      for (double t = 7.0; t < 15.0; t += 0.01) unseen += claimed(claims, t) ? 0.01 : 0.0;
      return 1.0 - unseen / 8.0;
    };
    EXPECT_GT(seen(3.0), 0.95) << noise;
    EXPECT_LT(seen(0.3), 0.3) << noise;
  }
}

TEST(Stationarity, SightIsCoarseOverGroundBelowTheNoise) {
  for (const double speed : {0.2, 0.8}) {
    EXPECT_GT(least_speed(speed, 1500.0), 0.4 * speed);
  }
}

// Traces with the same mean that are otherwise unrelated, as from places far apart. Once their
// differences are taken for noise, no speed is visible.
TEST(Stationarity, SightIsCoarseForTracesWithoutCoherence) {
  StationarityFrontEnd front_end(kWindow);
  std::vector<Sight> sights;
  Scene scene = go_on_at(0.0, 60.0);
  scene.end = 30.0;
  Noise noise(5);
  scene.spoil = [&](int i, GprTrace& trace) {
    if (i * kTraceStep < 6.0) return;
    for (float& sample : trace.samples) sample += static_cast<float>(noise(1000.0));
  };
  run(scene, front_end, &sights);
  ASSERT_FALSE(sights.empty());
  EXPECT_LT(sights.back().times_least, 10.0);
  const auto at_first = std::find_if(sights.begin(), sights.end(),
                                     [](const Sight& s) { return s.from > from_seconds(6.0); });
  EXPECT_GT(at_first->times_least, 100.0);
}

// It keeps what depends on the samples used alone. A window with other ones must not get that.
TEST(WindowAnalyser, DoesNotDependOnTheWindowsBefore) {
  constexpr int kSamples = 120, kTraces = 9;
  const Eigen::MatrixXf traces = Eigen::MatrixXf::Random(kSamples, kTraces);
  const Eigen::VectorXf weight = Eigen::VectorXf::Ones(kTraces);
  const Eigen::VectorXf all = Eigen::VectorXf::Ones(kSamples);
  Eigen::VectorXf some = all;
  some.head(30).setZero();
  WindowAnalyser used_before;
  for (const auto& used : {all, all, some, all, some, some}) {
    WindowAnalyser fresh;
    const WindowStatistics now = used_before.analyse(traces, weight, used);
    const WindowStatistics expected = fresh.analyse(traces, weight, used);
    EXPECT_EQ(now.samples, expected.samples);
    EXPECT_EQ(now.variance, expected.variance);
    EXPECT_EQ(now.trend, expected.trend);
    EXPECT_EQ(now.white_samples, expected.white_samples);
  }
  // Of another length, too.
  const WindowStatistics shorter = used_before.analyse(traces.topRows(100), weight, all.head(100));
  EXPECT_EQ(shorter.variance,
            WindowAnalyser().analyse(traces.topRows(100), weight, all.head(100)).variance);
}

}  // namespace
}  // namespace gprodom::gpr
