#include "gpr/motion/window_statistics.h"

#include <gtest/gtest.h>

namespace gprodom::gpr {
namespace {

constexpr int kSamples = 120, kTraces = 9;

// It keeps what depends on the samples used alone. A window with other ones must not get that.
TEST(WindowAnalyser, DoesNotDependOnTheWindowsBefore) {
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
