#include "map/merge/map_joiner.h"

#include <algorithm>
#include <cmath>

#include "map/merge/track_joint.h"
#include "map/path/map_path.h"

namespace gprodom {
namespace {

constexpr double kQueryEvery = 2.0;   // m between two searches of all ground
constexpr double kGiveUpAfter = 8.0;  // m without a revisit, then a hypothesis is dropped

// A join is proven by revisits over so many patches of ground, none of which overlaps another. A
// track that is located has one; a file that is wrong stays so.
constexpr double kProvenPatches = 4.0;
constexpr double kMostRefused = 0.25;  // of the revisits found

}  // namespace

bool JoinedTracks::proven(const GraphConfig& config) const {
  const auto refused = static_cast<double>(std::count_if(
      revisits.begin(), revisits.end(), [](const Revisited& one) { return !one.trusted; }));
  return proven_m >= kProvenPatches * config.patch_length &&
         refused <= kMostRefused * static_cast<double>(revisits.size());
}

MapJoiner::MapJoiner(const GroundMap& ground, std::size_t begin, const GraphConfig& config)
    : ground_(ground), begin_(begin), config_(config) {}

std::optional<JoinedTracks> MapJoiner::join(int map, const std::vector<gpr::MemoryRange>& runs) {
  const gpr::TraceMemory& memory = ground_.memory;
  const double reach = 2 * kNodeSpacing;
  const auto columns = [&](double metres) {
    return static_cast<std::size_t>(std::lround(metres / memory.spacing()));
  };
  std::optional<JoinedTracks> best;
  for (const gpr::MemoryRange& run : runs) {
    for (std::size_t end = run.first + columns(Locator::least_query()); end <= run.end;
         end += columns(kQueryEvery)) {
      const auto body = ground_.at(static_cast<double>(end - 1), reach);
      if (!body) continue;
      const auto found = locator_.place(ground_, begin_, {run.first, end}, body->pose);
      if (!found) continue;
      TrackJoint joint(ground_, map, runs, *found, end - 1, config_);
      const std::size_t far = columns(kGiveUpAfter);
      joint.sweep(std::max(run.first + far, end) - far, kGiveUpAfter);
      JoinedTracks joined = joint.result();
      const bool proven = joined.proven(config_);
      if (proven) {
        // Now that the poses are known better, the rest.
        for (int again = 0; again < 2; ++again) joint.sweep();
        joined = joint.result();
      }
      if (!best || joined.proven_m > best->proven_m) best = joined;
      if (proven && joined.proven(config_)) return joined;
    }
  }
  return best;
}

}  // namespace gprodom
