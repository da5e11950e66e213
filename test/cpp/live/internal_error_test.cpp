// A defect inside the estimator while it runs live: here an allocation that fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <new>
#include <random>
#include <utility>

#include "gprodom/live.h"
#include "live/runner.h"
#include "map/ground_map_file.h"
#include "pipeline/test_drive.h"
#include "support/sanitized.h"
#include "support/temporary_folder.h"
#include "support/told.h"

namespace {
// NOLINTBEGIN: operator new has no other way to know
thread_local bool next_allocation_fails = false;
thread_local int until_it_throws = 0;  // allocations, then one throws what is no std::exception
// NOLINTEND
}  // namespace

// Not inlined: where one of a pair is and the other is not, g++ takes them for another pair's.
#if !GPRODOM_SANITIZED
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (until_it_throws > 0 && --until_it_throws == 0) throw 7;  // NOLINT
  void* memory = std::exchange(next_allocation_fails, false) ? nullptr : std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  return std::malloc(size);  // as the other, since one delete serves both
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*size*/) noexcept {
  std::free(memory);
}
#endif

namespace gprodom {
namespace {

// The daemon continues: it reports the error and starts the estimator at the initialiser.
TEST(Live, InternalErrorRestartsTheEstimator) {
  if (GPRODOM_SANITIZED) GTEST_SKIP() << "the sanitizer's allocator cannot be made to fail";
  Outputs all;
  int calls = 0;  // one before each input, and one before each batch of them
  LiveOptions options;
  options.alive = [&calls] {
    if (++calls == 1000) next_allocation_fails = true;
  };
  {
    Live live(
        default_config(), [&all](const Outputs& out) { append(all, out); }, options);
    for (const Input& input : standing(10.0)) live.push(input);
  }
  EXPECT_EQ(std::count(all.warnings.begin(), all.warnings.end(),
                       "internal error: std::bad_alloc; the estimator restarts"),
            1);
  const auto& poses = all.odometry;
  ASSERT_FALSE(poses.empty());
  TimeNs silence = 0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    silence = std::max(silence, poses[i].time - poses[i - 1].time);
  EXPECT_GE(silence, from_seconds(0.9 * InitializerConfig().duration));
  EXPECT_EQ(poses.back().time, kDriveStart + 999 * kImuPeriod);
}

// Runs a drive on known ground through Live, with a failure after so many calls of `alive`. What
// was told.
std::vector<std::string> told_by(const Config& config, int after,
                                 const std::function<void()>& fail) {
  Outputs told;
  int calls = 0;
  LiveOptions options;
  options.alive = [&calls, &fail, after] {
    if (++calls == after) fail();
  };
  Live live(
      config, [&told](const Outputs& out) { append(told, out); }, options);
  for (const Input& input : later(there_and_back(3), 1000.0)) live.push(input);
  live.stop();
  return told.warnings;
}

TEST(Live, GroundOutlastsAnInternalError) {
  if (GPRODOM_SANITIZED) GTEST_SKIP() << "the sanitizer's allocator cannot be made to fail";
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  const std::string map = folder / "ground.map";
  const Config config = default_config({"state.directory=" + folder.path().string()});
  {
    Runner first(config, Execution::kInline);
    for (const Input& input : there_and_back(3)) first.feed(input);
    first.finish();
  }
  const auto size = fs::file_size(map);
  ASSERT_GT(size, 10000U);
  // bench/map_restarts.py asks for more.
  const char* asked = std::getenv("GPRODOM_MOMENTS");
  const int moments = asked != nullptr ? std::atoi(asked) : 4;
  std::mt19937 random(1);
  for (int i = 0; i < moments; ++i) {
    const int after = std::uniform_int_distribution<>(1, 8000)(random);
    const int allocations = std::uniform_int_distribution<>(1, 60)(random);
    SCOPED_TRACE(after);
    const auto told = told_by(config, after, [&] {
      if (i % 2 == 0)
        next_allocation_fails = true;
      else
        until_it_throws = allocations;
    });
    EXPECT_EQ(count_with(told, "; the estimator restarts"), 1);
    std::vector<std::string> notices;
    EXPECT_TRUE(read_ground_map(map, gpr::TraceMemoryOptions(), notices));
    EXPECT_TRUE(notices.empty());
    EXPECT_GE(fs::file_size(map), size);
    EXPECT_FALSE(fs::exists(folder / "ground.kept-1.map"));
  }
}

}  // namespace
}  // namespace gprodom
