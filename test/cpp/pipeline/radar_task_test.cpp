#include "pipeline/radar_task.h"

#include <gtest/gtest.h>

namespace gprodom {
namespace {

// What is noted at a trace `seconds` after one of 201 samples at 0.2 ns.
std::vector<std::string> notes_after(double seconds, std::size_t samples, double interval_s) {
  GprConfig config;
  config.front_end = FrontEndKind::kStationarity;
  RadarTask task(config);
  GprTrace trace;
  trace.time = from_seconds(100);
  trace.samples.assign(201, 1.0F);
  trace.sample_interval_s = 2e-10;
  EXPECT_TRUE(task.run({trace}, trace.time).notes.empty());
  trace.time += from_seconds(seconds);
  trace.samples.assign(samples, 1.0F);
  trace.sample_interval_s = interval_s;
  return task.run({trace}, trace.time).notes;
}

TEST(RadarTask, AnotherSettingOrAGapStartsTheFrontEndAfresh) {
  const std::string afresh = ": the radar front end starts afresh";
  EXPECT_TRUE(notes_after(0.05, 201, 2e-10).empty());
  EXPECT_TRUE(notes_after(0.05, 201, 2.0000001e-10).empty()) << "rounding is no other setting";
  EXPECT_EQ(notes_after(0.05, 181, 2e-10).at(0), "trace length changed" + afresh);
  EXPECT_EQ(notes_after(0.05, 201, 3e-10).at(0), "sample interval changed" + afresh);
  EXPECT_EQ(notes_after(1.05, 201, 2e-10).at(0), "gap in traces" + afresh);
}

}  // namespace
}  // namespace gprodom
