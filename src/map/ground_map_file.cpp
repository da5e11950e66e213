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

using gpr::BandLimit;
using gpr::Columns;
using gpr::LearntPatchFilter;
using gpr::MemoryRange;
using gpr::PatchFilter;
using gpr::TraceMemory;

const std::string kKind = "gprodom ground map ";
constexpr int kNewest = 3;

std::string title(int version) { return kKind + std::to_string(version); }

// Limit for the samples of a trace and the rows of a column; no radar has more.
constexpr std::uint32_t kMostSamples = 1U << 20U;
constexpr double kMostColumns = 1e4;  // of the running mean
constexpr std::size_t kLongestText = 100;
constexpr double kLeastError = 1e-6, kLargestError = 10.0;  // of a path: m, rad, ln
// Of a trace since version 2. What is made of the figure takes memory before a trace was seen.
constexpr std::uint32_t kMostSamplesRead = 1U << 16U;

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

void put_features(const TraceMemory& memory, MemoryRange run, ByteWriter& out) {
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

std::vector<TimeNs> get_times(ByteReader& in, std::uint64_t columns) {
  in.need(columns, sizeof(TimeNs));
  std::vector<TimeNs> times(columns);
  in.get_all(times.data(), times.size());
  if (!std::is_sorted(times.begin(), times.end())) in.refuse("the times of a run go back");
  return times;
}

double get_finite(ByteReader& in, const char* what) {
  const auto value = in.get<double>();
  if (!std::isfinite(value)) in.refuse(std::string(what) + " is not finite");
  return value;
}

void get_features(ByteReader& in, const PatchFilter& filter, TraceMemory& memory) {
  const auto columns = in.get<std::uint64_t>();
  const int direction = in.get<std::int8_t>() < 0 ? -1 : 1;
  const double distance = get_finite(in, "a distance");
  const std::vector<TimeNs> times = get_times(in, columns);
  const auto rows = static_cast<std::size_t>(filter.rows());
  in.need(columns, rows);
  std::vector<std::int8_t> levels(columns * rows);
  in.get_all(levels.data(), levels.size());
  Columns features(columns, rows);
  for (std::size_t i = 0; i < levels.size(); ++i)
    features.data()[i] = static_cast<float>(levels[i]) / TraceMemory::kLevelsPerUnit;
  memory.restore_run(filter, times, distance, direction, features);
}

void put_sessions(const GroundMap& ground, ByteWriter& out) {
  const std::vector<BandLimit>& sessions = ground.memory.sessions();
  out.put(static_cast<std::uint32_t>(sessions.front().step));
  out.put(static_cast<std::uint32_t>(sessions.size()));
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const SessionOrigin& origin = ground.origins.at(i);
    for (const double x : origin.antenna) out.put(x);
    out.put_text(origin.program);
    out.put_text(origin.robot.substr(0, kLongestText));
    for (const double x : {origin.errors.position, origin.errors.yaw, origin.errors.scale})
      out.put(std::clamp(x, kLeastError, kLargestError));
    out.put(sessions[i].low_cut);
    out.put(sessions[i].long_sigma);
    out.put_all(sessions[i].deviation.data(), static_cast<std::size_t>(sessions[i].rows()));
  }
}

std::string get_name(ByteReader& in, const char* whose) {
  std::string name = in.get_text();
  if (name.size() > kLongestText) in.refuse(std::string(whose) + " name is too long");
  return name;
}

SessionOrigin get_origin(ByteReader& in, int version) {
  SessionOrigin origin;
  for (double& x : origin.antenna) x = get_finite(in, "the antenna's position");
  origin.program = get_name(in, "a program's");
  if (version == 2) return origin;
  origin.robot = get_name(in, "a robot's");
  for (double* x : {&origin.errors.position, &origin.errors.yaw, &origin.errors.scale}) {
    *x = in.get<double>();
    if (!(*x >= kLeastError && *x <= kLargestError))
      in.refuse("the errors of a path are out of range");
  }
  return origin;
}

std::vector<BandLimit> get_sessions(ByteReader& in, GroundMap& ground) {
  BandLimit limit;
  limit.samples = ground.format.samples;
  limit.sample_interval = ground.format.sample_interval_s;
  const auto step = in.get<std::uint32_t>();
  if (step < 1 || limit.samples < 16 || limit.samples > kMostSamplesRead ||
      !(limit.sample_interval > 0.0) || step > limit.samples)
    in.refuse("its columns make no sense");
  limit.step = static_cast<int>(step);
  if (limit.rows() < 2 || limit.rows() > BandLimit::kMostRows)
    in.refuse("its columns make no sense");
  const auto rows = static_cast<std::size_t>(limit.rows());
  const auto count = in.get<std::uint32_t>();
  if (count == 0) in.refuse("it has no session");
  in.need(count, 5 * sizeof(double) + sizeof(std::uint32_t) + rows * sizeof(float));
  std::vector<BandLimit> sessions;
  for (std::uint32_t i = 0; i < count; ++i) {
    ground.origins.push_back(get_origin(in, ground.version));
    limit.low_cut = in.get<double>();
    limit.long_sigma = in.get<double>();
    limit.deviation.resize(limit.rows());
    in.get_all(limit.deviation.data(), rows);
    const bool sound = limit.low_cut * limit.sample_interval > 1e-6 &&
                       limit.low_cut * limit.sample_interval < 0.5 && limit.long_sigma > 0.0 &&
                       limit.long_sigma < kMostColumns &&
                       (limit.deviation.array() >= BandLimit::kLeast).all() &&
                       (limit.deviation.array() <= BandLimit::kGreatest).all();
    if (!sound) in.refuse("the limits of a session are out of range");
    sessions.push_back(limit);
  }
  return sessions;
}

void put_run(const TraceMemory& memory, MemoryRange range, ByteWriter& out) {
  const gpr::StoredRun run = memory.stored_run(range);
  out.put(static_cast<std::uint64_t>(range.size()));
  out.put(static_cast<std::uint32_t>(run.session));
  out.put(static_cast<std::int8_t>(run.direction));
  out.put(run.first_distance_m);
  out.put_all(run.times.data(), run.times.size());
  out.put_all(run.levels.data(), static_cast<std::size_t>(run.levels.size()));
}

gpr::StoredRun get_run(ByteReader& in, int rows) {
  gpr::StoredRun run;
  const auto columns = in.get<std::uint64_t>();
  run.session = in.get<std::uint32_t>();
  run.direction = in.get<std::int8_t>() < 0 ? -1 : 1;
  run.first_distance_m = get_finite(in, "a distance");
  run.times = get_times(in, columns);
  in.need(columns, static_cast<std::size_t>(rows));
  run.levels.resize(static_cast<Eigen::Index>(columns), rows);
  in.get_all(run.levels.data(), static_cast<std::size_t>(run.levels.size()));
  return run;
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

void put_places(const GroundMap& ground, const std::vector<KnownPlace>& places, ByteWriter& out) {
  out.put(static_cast<std::uint64_t>(places.size()));
  for (const KnownPlace& place : places) {
    out.put(static_cast<std::uint64_t>(place.column - ground.memory.kept().first));
    for (const double x : {place.distance_m, place.pose.p.x(), place.pose.p.y(), place.pose.yaw})
      out.put(x);
    out.put(static_cast<std::int32_t>(place.map));
  }
}

// The version in the title. A file of a later program is whole, and must not be called damaged.
int version_of(const std::string& name, std::string_view bytes) {
  if (bytes.substr(0, kKind.size()) != kKind) return kNewest;
  bytes.remove_prefix(kKind.size());
  const std::string version(bytes.substr(0, bytes.find('\n')));
  const bool number = !version.empty() && version.size() < 10 &&
                      version.find_first_not_of("0123456789") == std::string::npos;
  if (version == "1" || version == "2") return version == "1" ? 1 : 2;
  if (number && version != std::to_string(kNewest))
    throw FileError(name + ": cannot be used: it is a ground map of version " + version +
                    "; this program reads versions 1 to " + std::to_string(kNewest));
  return kNewest;
}

void put_format(const GroundMap& ground, ByteWriter& out) {
  out.put(ground.memory.spacing());
  out.put(static_cast<std::uint64_t>(ground.format.samples));
  out.put(ground.format.sample_interval_s);
}

void get_format(ByteReader& in, GroundMap& ground) {
  if (in.get<double>() != ground.memory.spacing()) in.refuse("its columns have another spacing");
  ground.format.samples = in.get<std::uint64_t>();
  ground.format.sample_interval_s = in.get<double>();
  if (ground.format.samples > kMostSamples) in.refuse("its traces are too long");
  if (!std::isfinite(ground.format.sample_interval_s) || ground.format.sample_interval_s < 0)
    in.refuse("its sample interval makes no sense");
}

// Ground that was read from version 1 is nothing but features.
std::string to_bytes_1(const GroundMap& ground, const std::vector<KnownPlace>& places) {
  ByteWriter out;
  put_format(ground, out);
  out.put(std::uint8_t{1});
  put(*ground.memory.filter(), out);
  const std::vector<MemoryRange> runs = ground.runs();
  out.put(static_cast<std::uint64_t>(runs.size()));
  for (const MemoryRange& run : runs) put_features(ground.memory, run, out);
  put_places(ground, places, out);
  return out.sealed(title(1));
}

void get_ground_1(ByteReader& in, GroundMap& ground) {
  get_format(in, ground);
  if (in.get<std::uint8_t>() == 0) return;
  const PatchFilter filter = get_filter(in);
  for (auto runs = in.get<std::uint64_t>(); runs > 0; --runs)
    get_features(in, filter, ground.memory);
  get_places(in, ground);
  in.expect_end();
}

void get_ground(ByteReader& in, GroundMap& ground) {
  get_format(in, ground);
  const auto parents = in.get<std::uint32_t>();
  in.need(parents, sizeof(std::uint64_t));
  ground.parents.resize(parents);
  in.get_all(ground.parents.data(), parents);
  if (in.get<std::uint8_t>() == 0) return in.expect_end();
  std::vector<BandLimit> sessions = get_sessions(in, ground);
  const int rows = sessions.front().rows();
  std::vector<gpr::StoredRun> runs;
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) runs.push_back(get_run(in, rows));
  ground.memory.restore(std::move(sessions), runs);
  get_places(in, ground);
  in.expect_end();
}

}  // namespace

std::string to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places) {
  const TraceMemory& memory = ground.memory;
  if (memory.filter() && memory.sessions().empty()) return to_bytes_1(ground, places);
  ByteWriter out;
  put_format(ground, out);
  out.put(static_cast<std::uint32_t>(ground.parents.size()));
  out.put_all(ground.parents.data(), ground.parents.size());
  out.put(static_cast<std::uint8_t>(memory.filter().has_value()));
  if (!memory.filter()) return out.sealed(title(kNewest));
  put_sessions(ground, out);
  const std::vector<MemoryRange> runs = ground.runs();
  out.put(static_cast<std::uint64_t>(runs.size()));
  for (const MemoryRange& run : runs) put_run(memory, run, out);
  put_places(ground, places, out);
  return out.sealed(title(kNewest));
}

GroundMap ground_map_from(const std::string& name, std::string_view bytes,
                          const gpr::TraceMemoryOptions& options) {
  GroundMap ground(options);
  ground.version = version_of(name, bytes);
  ByteReader in(name, bytes, title(ground.version));
  try {
    if (ground.version == 1) {
      get_ground_1(in, ground);
    } else {
      get_ground(in, ground);
    }
  } catch (const std::invalid_argument& error) {
    in.refuse(error.what());
  }
  ground.identity = in.checksum();
  return ground;
}

}  // namespace gprodom
