#include "pipeline/radar_task.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "config/config_keys.h"
#include "config/config_value.h"
#include "gpr/synthetic_ground.h"
#include "gprodom/error.h"
#include "support/noise.h"

namespace gprodom {
namespace {

// The answer to a trace that comes `seconds` after one of 201 samples at 0.2 ns, of antenna 0.
RadarAnswer answer_after(double seconds, std::size_t samples, double interval_s, int antenna = 0) {
  GprConfig config;
  config.front_end = FrontEndKind::kStationarity;
  RadarTask task(config);
  const TimeNs first = from_seconds(100), next = first + from_seconds(seconds);
  EXPECT_TRUE(task.run({gpr::flat_trace(first)}, first).notes.empty());
  GprTrace trace = gpr::flat_trace(next, samples, interval_s);
  trace.antenna_id = antenna;
  return task.run({trace}, next, antenna);
}

TEST(RadarTask, NewRadarSettingOrGapResetsTheFrontEnd) {
  const std::string reset = ": the radar front end is reset";
  EXPECT_TRUE(answer_after(0.05, 201, 2e-10).notes.empty());
  EXPECT_TRUE(answer_after(0.05, 201, 2.0000001e-10).notes.empty())
      << "rounding is no other setting";
  EXPECT_EQ(answer_after(0.05, 181, 2e-10).notes.at(0), "trace length changed" + reset);
  EXPECT_EQ(answer_after(0.05, 201, 2.0001e-10).notes.at(0), "sample interval changed" + reset);
  EXPECT_EQ(answer_after(1.05, 201, 2e-10).notes.at(0), "gap in traces" + reset);
  const RadarAnswer other = answer_after(0.05, 201, 2e-10, 1);
  EXPECT_EQ(other.notes.at(0), "another antenna" + reset);
  EXPECT_EQ(other.antenna, 1);
}

// Counts what it is asked and told.
struct Counts {
  int traces = 0, ticks = 0, resets = 0;
};
class Counter : public gpr::FrontEnd {
 public:
  explicit Counter(Counts& counts) : counts_(counts) {}
  void add_trace(const GprTrace& /*trace*/) override { ++counts_.traces; }
  std::vector<gpr::Finding> tick(TimeNs tick) override {
    ++counts_.ticks;
    return {gpr::Standstill{tick - 1, tick, "counter", 0.001, 1.0}};
  }
  void reset() override { ++counts_.resets; }

 private:
  Counts& counts_;
};

// Traces that come by distance pause at each stop.
TEST(RadarTask, AStopBetweenTracesByDistanceResetsNothing) {
  Counts counts;
  RadarTask task({}, [&] { return std::make_unique<Counter>(counts); });
  for (const double seconds : {100.0, 100.1, 160.0}) {
    const GprTrace trace = gpr::flat_trace(from_seconds(seconds));
    const RadarAnswer answer = task.run({trace}, trace.time, 0, {}, Trigger::kDistance);
    EXPECT_TRUE(answer.notes.empty());
    EXPECT_EQ(answer.findings.size(), 1U) << "a front end of another maker decides itself";
  }
  EXPECT_EQ(counts.traces, 3);
  EXPECT_EQ(counts.resets, 0);
}

// A radar over ground that does not move: a standstill, but for traces by distance or by what is
// not known.
TEST(RadarTask, OursSaysNothingOfTracesThatDoNotComeByTime) {
  const auto findings = [](Trigger trigger) {
    RadarTask task(GprConfig{});
    Noise noise(1);
    std::size_t found = 0;
    for (int i = 0; i < 200; ++i) {
      GprTrace trace = gpr::flat_trace(from_seconds(100) + 50'000'000 * static_cast<TimeNs>(i));
      for (int k = 0; k < 201; ++k)
        trace.samples[k] = static_cast<float>(2000.0 * std::sin(0.3 * k) + noise(20.0));
      found += task.run({trace}, trace.time, 0, {}, trigger).findings.size();
    }
    return found;
  };
  EXPECT_GT(findings(Trigger::kTime), 10U);
  EXPECT_EQ(findings(Trigger::kDistance), 0U);
  EXPECT_EQ(findings(Trigger::kAuto), 0U);
}

// Traces over ground, few at first, until the amplitude scale of sfm is known; then enough for two
// windows. Throws what the front end throws.
void run_over_ground(const GprConfig& config) {
  RadarTask task(config);
  Noise noise(1);
  TimeNs now = from_seconds(100);
  for (int tick = 0; tick < 20; ++tick) {
    std::vector<GprTrace> traces;
    for (int i = 0; i < 3; ++i) {
      traces.push_back(gpr::flat_trace(now += tick < 8 ? 900'000'000 : 33'000'000));
      for (float& sample : traces.back().samples) sample = static_cast<float>(noise(100.0));
    }
    task.run(traces, now);
  }
}

const FrontEndKind kFrontEnds[] = {FrontEndKind::kMotion,    FrontEndKind::kStationarity,
                                   FrontEndKind::kSfm,       FrontEndKind::kBscan,
                                   FrontEndKind::kDec,       FrontEndKind::kSalient,
                                   FrontEndKind::kTraceCount};

bool is_refused(const GprConfig& config) {
  try {
    RadarTask{config};
    return false;
  } catch (const ConfigError&) {
    return true;
  }
}

// A configuration that passes its checks must run: each key of the radar at both ends of its range,
// for each front end. An exception later would be an internal error at every trace.
TEST(RadarTask, EveryFrontEndThatCanBeBuiltRuns) {
  Config defaults;
  for (const FrontEndKind kind : kFrontEnds) {
    for (const ConfigKey& key : config_keys(defaults)) {
      const auto* range = std::get_if<Range>(&key.allowed);
      const bool of_radar = key.name.rfind("gpr.", 0) == 0 || key.name.rfind("paper.", 0) == 0;
      if (!of_radar || !range) continue;
      for (const double end : {range->minimum, range->maximum}) {
        if (!std::isfinite(end) || (range->above_minimum && end == range->minimum)) continue;
        std::ostringstream setting;
        const bool by_antenna = std::holds_alternative<AntennaOffsets*>(key.field);
        setting << key.name << "=" << (by_antenna ? "{0: " : "") << end << (by_antenna ? "}" : "");
        Config config = default_config({"gpr.front_end=" + name_of(kind), "paper.window_traces=15",
                                        "paper.columns=10", "paper.step=0.1", setting.str()});
        if (is_refused(config.gpr)) continue;
        EXPECT_NO_THROW(run_over_ground(config.gpr)) << setting.str() << " " << name_of(kind);
      }
    }
  }
}

// Each edge of the band is in its range, but the lower one is above the upper one.
TEST(RadarTask, BandWithSwappedEdgesIsRefused) {
  for (const FrontEndKind kind : {FrontEndKind::kMotion, FrontEndKind::kSfm}) {
    GprConfig config;
    config.front_end = kind;
    std::swap(config.filter.band_low, config.filter.band_high);
    EXPECT_THROW(RadarTask{config}, ConfigError);
  }
}

}  // namespace
}  // namespace gprodom
