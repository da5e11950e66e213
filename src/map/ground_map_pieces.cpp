#include "map/ground_map_pieces.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace gprodom {
namespace {

using gpr::BandLimit;
using gpr::MemoryRange;
using gpr::TraceMemory;

constexpr double kMostColumns = 1e4;  // of the running mean
constexpr std::size_t kLongestText = 100;
constexpr double kLeastError = 1e-6, kLargestError = 10.0;  // of a path: m, rad, ln
// Of a trace since version 2. What is made of the figure takes memory before a trace was seen.
constexpr std::uint32_t kMostSamplesRead = 1U << 16U;

std::string get_name(ByteReader& in, const char* whose) {
  std::string name = in.get_text();
  if (name.size() > kLongestText) in.refuse(std::string(whose) + " name is too long");
  return name;
}

SessionOrigin get_origin(ByteReader& in, int version) {
  SessionOrigin origin;
  for (double& x : origin.antenna) x = get_finite(in, "the antenna's position");
  if (version >= kWithAntennas) origin.antenna_id = in.get<std::int32_t>();
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

}  // namespace

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

void put_descent(const GroundMap& ground, ByteWriter& out) {
  out.put(static_cast<std::uint32_t>(ground.parents.size()));
  out.put_all(ground.parents.data(), ground.parents.size());
  out.put(static_cast<std::uint32_t>(ground.descent.size()));
  for (const Ancestor& ancestor : ground.descent) {
    out.put(ancestor.mark);
    out.put(ancestor.until);
  }
}

void get_descent(ByteReader& in, GroundMap& ground) {
  const auto parents = in.get<std::uint32_t>();
  in.need(parents, sizeof(std::uint64_t));
  ground.parents.resize(parents);
  in.get_all(ground.parents.data(), parents);
  if (ground.version < 4) return;
  const auto ancestors = in.get<std::uint32_t>();
  in.need(ancestors, sizeof(std::uint64_t) + sizeof(TimeNs));
  ground.descent.resize(ancestors);
  for (Ancestor& ancestor : ground.descent) {
    ancestor.mark = in.get<std::uint64_t>();
    ancestor.until = in.get<TimeNs>();
  }
}

void put_sessions(const GroundMap& ground, int version, ByteWriter& out) {
  const std::vector<BandLimit>& sessions = ground.memory.sessions();
  out.put(static_cast<std::uint32_t>(sessions.front().step));
  out.put(static_cast<std::uint32_t>(sessions.size()));
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const SessionOrigin& origin = ground.origins.at(i);
    for (const double x : origin.antenna) out.put(x);
    if (version >= kWithAntennas) out.put(static_cast<std::int32_t>(origin.antenna_id));
    out.put_text(origin.program);
    out.put_text(origin.robot.substr(0, kLongestText));
    for (const double x : {origin.errors.position, origin.errors.yaw, origin.errors.scale})
      out.put(std::clamp(x, kLeastError, kLargestError));
    out.put(sessions[i].low_cut);
    out.put(sessions[i].long_sigma);
    out.put_all(sessions[i].deviation.data(), static_cast<std::size_t>(sessions[i].rows()));
  }
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

static void put_run(const TraceMemory& memory, MemoryRange range, ByteWriter& out) {
  const gpr::StoredRun run = memory.stored_run(range);
  out.put(static_cast<std::uint64_t>(range.size()));
  out.put(static_cast<std::uint32_t>(run.session));
  out.put(static_cast<std::int8_t>(run.direction));
  out.put(run.first_distance_m);
  out.put_all(run.times.data(), run.times.size());
  out.put_all(run.levels.data(), static_cast<std::size_t>(run.levels.size()));
}

void put_runs(const GroundMap& ground, std::size_t first, ByteWriter& out) {
  std::vector<MemoryRange> runs;
  for (MemoryRange run : ground.runs()) {
    run.first = std::max(run.first, first);
    if (run.first < run.end) runs.push_back(run);
  }
  out.put(static_cast<std::uint64_t>(runs.size()));
  for (const MemoryRange& run : runs) put_run(ground.memory, run, out);
}

static gpr::StoredRun get_run(ByteReader& in, int rows) {
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

std::vector<gpr::StoredRun> get_runs(ByteReader& in, int rows) {
  std::vector<gpr::StoredRun> runs;
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) runs.push_back(get_run(in, rows));
  return runs;
}

void put_places(const std::vector<KnownPlace>& places, std::size_t begin, ByteWriter& out) {
  out.put(static_cast<std::uint64_t>(places.size()));
  for (const KnownPlace& place : places) {
    out.put(static_cast<std::uint64_t>(place.column - begin));
    for (const double x : {place.distance_m, place.pose.p.x(), place.pose.p.y(), place.pose.yaw})
      out.put(x);
    out.put(static_cast<std::int32_t>(place.map));
  }
}

std::vector<KnownPlace> get_places(ByteReader& in) {
  const auto count = in.get<std::uint64_t>();
  in.need(count, 44);
  std::vector<KnownPlace> places(count);
  for (KnownPlace& place : places) {
    place.column = in.get<std::uint64_t>();
    for (double* x : {&place.distance_m, &place.pose.p.x(), &place.pose.p.y(), &place.pose.yaw})
      *x = in.get<double>();
    place.map = in.get<std::int32_t>();
  }
  return places;
}

void expect_places(const ByteReader& in, const GroundMap& ground) {
  std::uint64_t last = 0;
  for (const KnownPlace& place : ground.places) {
    const bool sound = place.column >= last && place.column < ground.memory.kept().end &&
                       std::isfinite(place.distance_m) && place.pose.p.allFinite() &&
                       std::isfinite(place.pose.yaw) && place.map >= 0;
    if (!sound) in.refuse("a place of it makes no sense");
    last = place.column;
  }
}

void put_datums(const std::map<int, MapDatum>& datums, ByteWriter& out) {
  out.put(static_cast<std::uint32_t>(datums.size()));
  for (const auto& [map, datum] : datums) {
    out.put(static_cast<std::int32_t>(map));
    for (const double x : {datum.pose.p.x(), datum.pose.p.y(), datum.z, datum.pose.yaw}) out.put(x);
    out.put_all(datum.covariance.data(), static_cast<std::size_t>(datum.covariance.size()));
    out.put(static_cast<std::uint8_t>(datum.origin.has_value()));
    if (datum.origin) out.put_all(datum.origin->data(), 3);
  }
}

static MapDatum get_datum(ByteReader& in) {
  MapDatum datum;
  for (double* x : {&datum.pose.p.x(), &datum.pose.p.y(), &datum.z, &datum.pose.yaw})
    *x = get_finite(in, "a place in site");
  in.get_all(datum.covariance.data(), static_cast<std::size_t>(datum.covariance.size()));
  const bool sound = datum.covariance.allFinite() &&
                     datum.covariance.isApprox(datum.covariance.transpose()) &&
                     datum.covariance.llt().info() == Eigen::Success;
  if (!sound) in.refuse("the covariance of a place in site makes no sense");
  if (in.get<std::uint8_t>() == 0) return datum;
  Geodetic origin;
  in.get_all(origin.data(), 3);
  // Longitudes from -180 to 180 and from 0 to 360 are both in use.
  if (!(std::abs(origin.x()) <= 90.0 && std::abs(origin.y()) <= 360.0 &&
        std::abs(origin.z()) < 1e5))
    in.refuse("the origin of site is no place on the Earth");
  datum.origin = origin;
  return datum;
}

std::map<int, MapDatum> get_datums(ByteReader& in) {
  std::map<int, MapDatum> datums;
  for (auto left = in.get<std::uint32_t>(); left > 0; --left) {
    const auto map = in.get<std::int32_t>();
    if (map < 0 || !datums.emplace(map, get_datum(in)).second)
      in.refuse("the numbers of its maps in site make no sense");
  }
  return datums;
}

}  // namespace gprodom
