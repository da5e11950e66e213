#include "map/ground_map_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "base/sealed_bytes.h"
#include "gprodom/error.h"

namespace gprodom {
namespace {

using gpr::Columns;
using gpr::LearntPatchFilter;
using gpr::MemoryRange;
using gpr::PatchFilter;
using gpr::TraceMemory;

const std::string kKind = "gprodom ground map ";
const std::string kVersion = "1";
const std::string kTitle = kKind + kVersion;

// Limit for the samples of a trace and the rows of a column; no radar has more.
constexpr std::uint32_t kMostSamples = 1U << 20U;

void put(const PatchFilter& filter, ByteWriter& out) {
  const LearntPatchFilter& learnt = filter.learnt();
  out.put(static_cast<std::uint32_t>(learnt.projection.rows()));
  out.put(static_cast<std::uint32_t>(learnt.projection.cols()));
  out.put_all(learnt.projection.data(), static_cast<std::size_t>(learnt.projection.size()));
  for (const double x : {learnt.row_interval, learnt.centre, learnt.long_sigma, learnt.short_sigma})
    out.put(x);
}

PatchFilter get_filter(ByteReader& in) {
  LearntPatchFilter learnt;
  const auto rows = in.get<std::uint32_t>(), samples = in.get<std::uint32_t>();
  if (rows > kMostSamples || samples > kMostSamples) in.refuse("its traces are too long");
  in.need(std::size_t{rows} * samples, sizeof(float));
  learnt.projection.resize(rows, samples);
  in.get_all(learnt.projection.data(), std::size_t{rows} * samples);
  for (double* x : {&learnt.row_interval, &learnt.centre, &learnt.long_sigma, &learnt.short_sigma})
    *x = in.get<double>();
  return PatchFilter(std::move(learnt));
}

void put_run(const TraceMemory& memory, MemoryRange run, ByteWriter& out) {
  const gpr::MemoryColumn first = memory.column(run.first);
  out.put(static_cast<std::uint64_t>(run.size()));
  out.put(static_cast<std::int8_t>(first.direction));
  out.put(first.distance_m);
  for (std::size_t i = run.first; i < run.end; ++i) out.put(memory.column(i).time);
  const Columns features = TraceMemory::kLevelsPerUnit * memory.patch(run);
  std::vector<std::int8_t> levels(static_cast<std::size_t>(features.size()));
  for (std::size_t i = 0; i < levels.size(); ++i)
    levels[i] = static_cast<std::int8_t>(std::lround(features.data()[i]));
  out.put_all(levels.data(), levels.size());
}

void get_run(ByteReader& in, const PatchFilter& filter, TraceMemory& memory) {
  const auto columns = in.get<std::uint64_t>();
  const int direction = in.get<std::int8_t>() < 0 ? -1 : 1;
  const auto distance = in.get<double>();
  if (!std::isfinite(distance)) in.refuse("a distance is not finite");
  in.need(columns, sizeof(TimeNs));
  std::vector<TimeNs> times(columns);
  in.get_all(times.data(), times.size());
  if (!std::is_sorted(times.begin(), times.end())) in.refuse("the times of a run go back");
  const auto rows = static_cast<std::size_t>(filter.rows());
  in.need(columns, rows);
  std::vector<std::int8_t> levels(columns * rows);
  in.get_all(levels.data(), levels.size());
  Columns features(columns, rows);
  for (std::size_t i = 0; i < levels.size(); ++i)
    features.data()[i] = static_cast<float>(levels[i]) / TraceMemory::kLevelsPerUnit;
  memory.restore_run(filter, times, distance, direction, features);
}

void get_places(ByteReader& in, GroundMap& ground) {
  const auto count = in.get<std::uint64_t>();
  in.need(count, 44);
  std::uint64_t last = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    KnownPlace place;
    place.column = in.get<std::uint64_t>();
    place.distance_m = in.get<double>();
    place.pose.p.x() = in.get<double>();
    place.pose.p.y() = in.get<double>();
    place.pose.yaw = in.get<double>();
    place.map = in.get<std::int32_t>();
    const bool sound = place.column >= last && place.column < ground.memory.kept().end &&
                       std::isfinite(place.distance_m) && place.pose.p.allFinite() &&
                       std::isfinite(place.pose.yaw) && place.map >= 0;
    if (!sound) in.refuse("a place of it makes no sense");
    last = place.column;
    ground.places.push_back(place);
  }
}

// A file of a later program is whole, and must not be called damaged.
void refuse_other_version(const std::string& name, std::string_view bytes) {
  if (bytes.substr(0, kKind.size()) != kKind) return;
  bytes.remove_prefix(kKind.size());
  const std::string version(bytes.substr(0, bytes.find('\n')));
  const bool number = !version.empty() && version.size() < 10 &&
                      version.find_first_not_of("0123456789") == std::string::npos;
  if (number && version != kVersion)
    throw FileError(name + ": cannot be used: it is a ground map of version " + version +
                    "; this program reads version " + kVersion);
}

}  // namespace

std::string to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places) {
  const TraceMemory& memory = ground.memory;
  ByteWriter out;
  out.put(memory.spacing());
  out.put(static_cast<std::uint64_t>(ground.format.samples));
  out.put(ground.format.sample_interval_s);
  out.put(static_cast<std::uint8_t>(memory.filter().has_value()));
  if (!memory.filter()) return out.sealed(kTitle);
  put(*memory.filter(), out);
  const MemoryRange kept = memory.kept();
  std::vector<MemoryRange> runs;
  for (std::size_t column = kept.first; column < kept.end; column = runs.back().end)
    runs.push_back(memory.run_of(column));
  out.put(static_cast<std::uint64_t>(runs.size()));
  for (const MemoryRange& run : runs) put_run(memory, run, out);
  out.put(static_cast<std::uint64_t>(places.size()));
  for (const KnownPlace& place : places) {
    out.put(static_cast<std::uint64_t>(place.column - kept.first));
    for (const double x : {place.distance_m, place.pose.p.x(), place.pose.p.y(), place.pose.yaw})
      out.put(x);
    out.put(static_cast<std::int32_t>(place.map));
  }
  return out.sealed(kTitle);
}

GroundMap ground_map_from(const std::string& name, std::string_view bytes,
                          const gpr::TraceMemoryOptions& options) {
  refuse_other_version(name, bytes);
  ByteReader in(name, bytes, kTitle);
  GroundMap ground(options);
  if (in.get<double>() != options.spacing_m) in.refuse("its columns have another spacing");
  ground.format.samples = in.get<std::uint64_t>();
  ground.format.sample_interval_s = in.get<double>();
  if (ground.format.samples > kMostSamples) in.refuse("its traces are too long");
  if (!std::isfinite(ground.format.sample_interval_s) || ground.format.sample_interval_s < 0)
    in.refuse("its sample interval makes no sense");
  if (in.get<std::uint8_t>() == 0) return ground;
  try {
    const PatchFilter filter = get_filter(in);
    for (auto runs = in.get<std::uint64_t>(); runs > 0; --runs) get_run(in, filter, ground.memory);
  } catch (const std::invalid_argument& error) {
    in.refuse(error.what());
  }
  get_places(in, ground);
  in.expect_end();
  return ground;
}

}  // namespace gprodom
