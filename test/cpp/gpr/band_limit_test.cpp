#include "gpr/revisit/band_limit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gprodom::gpr {
namespace {

// Away from the ends, over the periods that features have.
TEST(PhaseTurn, TurnsEachFrequencyByTheAngle) {
  constexpr int kRows = 80, kEnd = 20;
  for (const double angle : {-0.7, 0.4, 1.2, 0.5 * M_PI}) {
    const Columns turn = phase_turn(kRows, angle);
    for (const double period : {2.5, 4.0, 7.0, 11.0}) {
      Columns wave(1, kRows);
      for (int row = 0; row < kRows; ++row)
        wave(0, row) = static_cast<float>(std::cos(2 * M_PI * row / period));
      const Columns turned = wave * turn.transpose();
      for (int row = kEnd; row < kRows - kEnd; ++row) {
        EXPECT_NEAR(turned(0, row), std::cos(2 * M_PI * row / period + angle), 0.08)
            << angle << " " << period << " " << row;
      }
    }
  }
}

}  // namespace
}  // namespace gprodom::gpr
