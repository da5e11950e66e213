// Decoding of position_fix_t.
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "gprodom/lcm_io.h"
#include "lcmtypes/gprodom/position_fix_t.hpp"

namespace gprodom {
namespace {

Input decoded(const position_fix_t& m) {
  std::vector<unsigned char> bytes(static_cast<std::size_t>(m.getEncodedSize()));
  m.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return *decode_input(ChannelConfig(), "POSITION_FIX", bytes.data(), bytes.size());
}

position_fix_t message() {
  position_fix_t m{};
  m.utime = 1;
  m.frame = position_fix_t::GEODETIC;
  m.quality = position_fix_t::FIXED;
  m.antenna_id = 3;
  m.has_heading = 1;
  m.heading = 0.5;
  m.heading_sigma = 0.01;
  for (int i = 0; i < 3; ++i) m.position[i] = 10.0 + i;
  for (int i = 0; i < 9; ++i) m.covariance[i] = i;
  return m;
}

TEST(LcmInput, DecodesPositionFix) {
  const auto fix = std::get<PositionFix>(decoded(message()));
  EXPECT_EQ(fix.time, 1000);
  EXPECT_EQ(fix.frame, FixFrame::kGeodetic);
  EXPECT_EQ(fix.position, Eigen::Vector3d(10, 11, 12));
  EXPECT_EQ(fix.covariance(0, 1), 1.0);  // row-major
  EXPECT_EQ(fix.quality, FixQuality::kFixed);
  EXPECT_EQ(fix.antenna_id, 3);
  EXPECT_TRUE(fix.has_heading);
  EXPECT_EQ(fix.heading, 0.5);
  EXPECT_EQ(fix.heading_sigma, 0.01);
}

TEST(LcmInput, RefusesPositionFixOfUnknownFrameOrQuality) {
  position_fix_t m = message();
  m.frame = 2;
  EXPECT_NE(std::get<Rejection>(decoded(m)).reason.find("frame"), std::string::npos);
  m = message();
  m.quality = 5;
  EXPECT_NE(std::get<Rejection>(decoded(m)).reason.find("quality"), std::string::npos);
}

}  // namespace
}  // namespace gprodom
