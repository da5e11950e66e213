// A defect inside the estimator while it runs live: here an allocation that fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <utility>

#include "gprodom/live.h"
#include "pipeline/test_drive.h"
#include "support/sanitized.h"

namespace {
thread_local bool next_allocation_fails = false;  // NOLINT: operator new has no other way to know
}

#if !GPRODOM_SANITIZED
void* operator new(std::size_t size) {
  void* memory = std::exchange(next_allocation_fails, false) ? nullptr : std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return std::malloc(size);  // as the other, since one delete serves both
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
#endif

namespace gprodom {
namespace {

// The daemon continues: it reports the error and starts the estimator at the initialiser.
TEST(Live, InternalErrorRestartsTheEstimator) {
  if (GPRODOM_SANITIZED) GTEST_SKIP() << "the sanitizer's allocator cannot be made to fail";
  std::vector<TimeNs> times;
  std::vector<std::string> warnings;
  int calls = 0;  // one before each input, and one before each batch of them
  LiveOptions options;
  options.alive = [&calls] {
    if (++calls == 1000) next_allocation_fails = true;
  };
  {
    Live live(
        default_config(),
        [&](const Outputs& out) {
          for (const auto& estimate : out.odometry) times.push_back(estimate.time);
          warnings.insert(warnings.end(), out.warnings.begin(), out.warnings.end());
        },
        options);
    for (const Input& input : standing(10.0)) live.push(input);
  }
  EXPECT_EQ(std::count_if(warnings.begin(), warnings.end(),
                          [](const std::string& text) {
                            return text ==
                                   "internal error: std::bad_alloc; the estimator "
                                   "restarts";
                          }),
            1);
  ASSERT_FALSE(times.empty());
  TimeNs silence = 0;
  for (std::size_t i = 1; i < times.size(); ++i)
    silence = std::max(silence, times[i] - times[i - 1]);
  EXPECT_GE(silence, from_seconds(0.9 * InitializerConfig().duration));
  EXPECT_EQ(times.back(), kDriveStart + 999 * kImuPeriod);
}

}  // namespace
}  // namespace gprodom
