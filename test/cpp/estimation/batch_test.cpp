#include "estimation/batch.h"

#include <gtest/gtest.h>

#include "estimation/noisy_drive.h"

namespace gprodom {
namespace {

// Tells of each slip that it was given.
class SlipListener final : public Factor {
 public:
  explicit SlipListener(std::vector<double>& told) : told_(told) {}
  int dimension() const override { return 0; }
  void evaluate(const NavState& /*a*/, const NavState& /*b*/, Residual& /*r*/, Jacobian* /*Ja*/,
                Jacobian* /*Jb*/) const override {}
  std::shared_ptr<const Factor> with_slip(double l) const override {
    told_.push_back(l);
    return nullptr;
  }

 private:
  std::vector<double>& told_;
};

// Eleven hours of states. A pass over all links for each state would take a minute.
TEST(Batch, SlipsReachTheirStatesInOnePass) {
  constexpr std::size_t kStates = 200'000;
  Batch batch(NavState(), origin_prior(NavState(), StateVector::Ones()));
  std::vector<double> told;
  const auto listener = std::make_shared<SlipListener>(told);
  for (std::size_t i = 1; i < kStates; ++i) {
    batch.add_state(NavState());
    batch.add_factor(i - 1, i, listener);
  }
  std::vector<std::optional<double>> slips(kStates);
  for (std::size_t i = 0; i + 1 < kStates; ++i)
    if (i % 3 != 0) slips[i] = static_cast<double>(i);
  batch.set_slips(slips);
  ASSERT_EQ(told.size(), (kStates - 1) * 2 / 3);
  std::size_t k = 0;
  for (const std::optional<double>& slip : slips) {
    if (slip) {
      ASSERT_EQ(told[k++], *slip);
    }
  }
}

}  // namespace
}  // namespace gprodom
