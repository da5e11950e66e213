#include "gpr/sequential/apexes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace gprodom::gpr {
namespace {

constexpr double kInterval = 2e-10, kZero = 4e-9, kFrequency = 5e8;
constexpr int kSamples = 201, kColumns = 100;
const ApexOptions kOptions{kInterval, kZero};

double ricker(double t) {
  const double a = std::pow(M_PI * kFrequency * t, 2);
  return (1.0 - 2.0 * a) * std::exp(-a);
}

// Noise of unit variance that is alike in neighbouring columns, as echoes of the ground are.
Eigen::MatrixXf clutter(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Eigen::MatrixXf bscan = Eigen::MatrixXf::NullaryExpr(
      kSamples, kColumns, [&](Eigen::Index, Eigen::Index) { return normal(random); });
  for (int c = 1; c < kColumns; ++c) bscan.col(c) = 0.8F * bscan.col(c - 1) + 0.6F * bscan.col(c);
  return bscan;
}

void add_hyperbola(Eigen::MatrixXf& bscan, double column, double time, double widening,
                   double amplitude) {
  for (int c = 0; c < kColumns; ++c) {
    const double arrival = kZero + std::hypot(time, widening * (c - column));
    for (int r = 0; r < kSamples; ++r)
      bscan(r, c) += static_cast<float>(amplitude * ricker(r * kInterval - arrival));
  }
}

TEST(Apexes, ColumnTimeAndWideningOfAHyperbolaAreFound) {
  for (const double widening : {0.25e-9, 0.4e-9, 0.7e-9}) {
    Eigen::MatrixXf bscan = clutter(3);
    add_hyperbola(bscan, 46.3, 10e-9, widening, 8.0);
    const std::vector<Apex> apexes = find_apexes(bscan, kOptions);
    ASSERT_FALSE(apexes.empty()) << widening;
    EXPECT_NEAR(apexes[0].column, 46.3, 0.5);
    EXPECT_NEAR(apexes[0].time_s, 10e-9, 0.3e-9);
    EXPECT_NEAR(apexes[0].widening_s / widening, 1.0, 0.07);
  }
}

TEST(Apexes, TwoAreToldApartAndTheStrongerComesFirst) {
  Eigen::MatrixXf bscan = clutter(4);
  add_hyperbola(bscan, 30.0, 8e-9, 0.4e-9, 8.0);
  add_hyperbola(bscan, 70.0, 14e-9, 0.4e-9, 16.0);
  const std::vector<Apex> apexes = find_apexes(bscan, kOptions);
  ASSERT_EQ(apexes.size(), 2U);
  EXPECT_NEAR(apexes[0].column, 70.0, 0.5);
  EXPECT_NEAR(apexes[1].column, 30.0, 0.5);
}

// 1 % of B-scans of random ground have one: of 40, more than three in 2 % of all cases at most.
TEST(Apexes, RandomGroundHasHardlyAny) {
  int with = 0;
  for (unsigned seed = 100; seed < 140; ++seed)
    with += find_apexes(clutter(seed), kOptions).empty() ? 0 : 1;
  EXPECT_LE(with, 3);
}

TEST(Apexes, ALayerIsNone) {
  Eigen::MatrixXf bscan = clutter(5);
  add_hyperbola(bscan, 50.0, 10e-9, 0.0, 20.0);
  EXPECT_TRUE(find_apexes(bscan, kOptions).empty());
}

TEST(Apexes, ThresholdIsThatOfItsDistribution) {
  // n independent columns: the median is 1 - 2^(-1/(n-1)).
  const double n = 12.0;
  const double threshold = semblance_threshold(1.0 - std::pow(2.0, -1.0 / (n - 1.0)), 1e-3);
  EXPECT_NEAR(std::pow(1.0 - threshold, n - 1.0), 1e-3, 1e-9);
  EXPECT_EQ(semblance_threshold(0.0, 1e-3), 1.0);
}

TEST(Apexes, EmptyShortAndWrongInputGivesNoneOrIsRefused) {
  EXPECT_TRUE(find_apexes(Eigen::MatrixXf(), kOptions).empty());
  EXPECT_TRUE(find_apexes(Eigen::MatrixXf::Ones(20, 3), kOptions).empty());
  EXPECT_TRUE(find_apexes(Eigen::MatrixXf::Zero(kSamples, kColumns), kOptions).empty());
  EXPECT_THROW(find_apexes(Eigen::MatrixXf::Zero(9, 9), ApexOptions()), std::invalid_argument);
}

}  // namespace
}  // namespace gprodom::gpr
