#include "map/ground_map_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

#include "base/atomic_file.h"
#include "gprodom/error.h"
#include "map/ground_map_pieces.h"

namespace gprodom {
namespace {

using gpr::BandLimit;
using gpr::Columns;
using gpr::LearntPatchFilter;
using gpr::MemoryRange;
using gpr::PatchFilter;
using gpr::TraceMemory;

const std::string kKind = "gprodom ground map ";
constexpr int kNewest = kWithAntennas;
constexpr int kPlain = 4;  // what needs no later one is written so, for programs that know none

std::string title(int version) { return kKind + std::to_string(version); }

// Those of the maps that have places.
std::map<int, MapDatum> datums_of(const GroundMap& ground, const std::vector<KnownPlace>& places) {
  std::map<int, MapDatum> datums;
  for (const KnownPlace& place : places) {
    const auto datum = ground.datums.find(place.map);
    if (datum != ground.datums.end()) datums.insert(*datum);
  }
  return datums;
}

int version_for(const GroundMap& ground, const std::map<int, MapDatum>& datums) {
  const auto other = [](const SessionOrigin& origin) { return origin.antenna_id != 0; };
  if (std::any_of(ground.origins.begin(), ground.origins.end(), other)) return kWithAntennas;
  return datums.empty() ? kPlain : kWithDatums;
}

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

// The version in the title. A file of a later program is whole, and must not be called damaged.
int version_of(const std::string& name, std::string_view bytes) {
  if (bytes.substr(0, kKind.size()) != kKind) return kNewest;
  bytes.remove_prefix(kKind.size());
  const std::string version(bytes.substr(0, bytes.find('\n')));
  const bool number = !version.empty() && version.size() < 10 &&
                      version.find_first_not_of("0123456789") == std::string::npos;
  const int known = number ? std::stoi(version) : kNewest;
  if (known >= 1 && known <= kNewest) return known;
  if (number)
    throw FileError(name + ": cannot be used: it is a ground map of version " + version +
                    "; this program reads versions 1 to " + std::to_string(kNewest));
  return kNewest;
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
  put_places(places, ground.memory.kept().first, out);
  return out.sealed(title(1));
}

void get_ground_1(ByteReader& in, GroundMap& ground) {
  get_format(in, ground);
  if (in.get<std::uint8_t>() == 0) return;
  const PatchFilter filter = get_filter(in);
  for (auto runs = in.get<std::uint64_t>(); runs > 0; --runs)
    get_features(in, filter, ground.memory);
  ground.places = get_places(in);
  expect_places(in, ground);
  in.expect_end();
}

// What a file since version 2 holds, before the memory is made of it.
struct Pieces {
  std::vector<BandLimit> sessions;
  std::vector<gpr::StoredRun> runs;
};

Pieces get_pieces(ByteReader& in, GroundMap& ground) {
  get_format(in, ground);
  get_descent(in, ground);
  Pieces pieces;
  if (in.get<std::uint8_t>() != 0) {
    pieces.sessions = get_sessions(in, ground);
    pieces.runs = get_runs(in, pieces.sessions.front().rows());
    ground.places = get_places(in);
    if (ground.version >= kWithDatums) ground.datums = get_datums(in);
  }
  in.expect_end();
  return pieces;
}

void restore(const ByteReader& in, Pieces pieces, GroundMap& ground) {
  if (pieces.sessions.empty()) return;
  ground.memory.restore(std::move(pieces.sessions), pieces.runs);
  expect_places(in, ground);
}

// Cuts the runs off behind so many columns.
void keep_first(std::uint64_t columns, const ByteReader& in, std::vector<gpr::StoredRun>& runs) {
  std::size_t whole = 0;
  for (; whole < runs.size() && runs[whole].times.size() <= columns; ++whole)
    columns -= runs[whole].times.size();
  if (columns > 0) {
    if (whole == runs.size()) in.refuse("it goes on from more columns than there are");
    runs[whole].times.resize(columns);
    runs[whole].levels.conservativeResize(static_cast<Eigen::Index>(columns), Eigen::NoChange);
    ++whole;
  }
  runs.resize(whole);
}

void append_run(const gpr::StoredRun& more, gpr::StoredRun& run) {
  run.times.insert(run.times.end(), more.times.begin(), more.times.end());
  gpr::Levels levels(run.levels.rows() + more.levels.rows(), run.levels.cols());
  levels << run.levels, more.levels;
  run.levels = std::move(levels);
}

// Of version 1 it is as in a whole file of kPlain, and so on.
std::string title_of_newest(int version) {
  return "gprodom newest ground " + std::to_string(version - kPlain + 1);
}

int version_of_newest(std::string_view bytes) {
  int version = kNewest;
  while (version > kPlain &&
         bytes.substr(0, title_of_newest(version).size()) != title_of_newest(version))
    --version;
  return version;
}

ByteReader newest_reader(const std::string& name, std::string_view bytes) {
  return {name, bytes, title_of_newest(version_of_newest(bytes))};
}

// Exchanges what has changed since the whole file was written. The ground is that of no file then.
void get_newest(ByteReader& in, int version, GroundMap& ground, Pieces& pieces) {
  in.get<std::uint64_t>();  // the file's identity
  const auto columns = in.get<std::uint64_t>(), columns_before = in.get<std::uint64_t>();
  const bool continues = in.get<std::uint8_t>() != 0;
  std::vector<KnownPlace> places = std::move(ground.places);
  const TraceFormat format = ground.format;
  ground.version = version;
  ground.origins.clear();
  Pieces newest = get_pieces(in, ground);
  const bool same =
      same_format(format, ground.format) && !newest.sessions.empty() &&
      (pieces.sessions.empty() || pieces.sessions.front().rows() == newest.sessions.front().rows());
  if (!same) in.refuse("its traces are not those of the file that it goes on from");
  keep_first(columns, in, pieces.runs);
  auto first = newest.runs.begin();
  if (continues && first != newest.runs.end() && !pieces.runs.empty())
    append_run(*first++, pieces.runs.back());
  pieces.runs.insert(pieces.runs.end(), first, newest.runs.end());
  pieces.sessions = std::move(newest.sessions);
  const auto is_newer = [&](const KnownPlace& place) { return place.column >= columns_before; };
  places.erase(std::remove_if(places.begin(), places.end(), is_newer), places.end());
  places.insert(places.end(), ground.places.begin(), ground.places.end());
  ground.places = std::move(places);
}

}  // namespace

std::string to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places) {
  const TraceMemory& memory = ground.memory;
  if (memory.filter() && memory.sessions().empty()) return to_bytes_1(ground, places);
  ByteWriter out;
  put_format(ground, out);
  put_descent(ground, out);
  out.put(static_cast<std::uint8_t>(memory.filter().has_value()));
  if (!memory.filter()) return out.sealed(title(kPlain));
  const std::map<int, MapDatum> datums = datums_of(ground, places);
  const int version = version_for(ground, datums);
  put_sessions(ground, version, out);
  put_runs(ground, memory.kept().first, out);
  put_places(places, memory.kept().first, out);
  if (version >= kWithDatums) put_datums(datums, out);
  return out.sealed(title(version));
}

std::string newest_to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places,
                            std::size_t first_of_drive, const SavedColumns& saved) {
  const TraceMemory& memory = ground.memory;
  const std::size_t drive = std::max(first_of_drive, saved.first);
  const bool more = saved.end < memory.kept().end;
  ByteWriter out;
  out.put(saved.identity);
  out.put(static_cast<std::uint64_t>(saved.end - saved.first));
  out.put(static_cast<std::uint64_t>(drive - saved.first));
  out.put(static_cast<std::uint8_t>(more && memory.run_of(saved.end).first < saved.end));
  put_format(ground, out);
  put_descent(ground, out);
  out.put(std::uint8_t{1});
  const std::map<int, MapDatum> datums = datums_of(ground, places);
  const int version = version_for(ground, datums);
  put_sessions(ground, version, out);
  put_runs(ground, saved.end, out);
  std::vector<KnownPlace> newest;
  std::copy_if(places.begin(), places.end(), std::back_inserter(newest),
               [drive](const KnownPlace& place) { return place.column >= drive; });
  put_places(newest, saved.first, out);
  if (version >= kWithDatums) put_datums(datums, out);
  return out.sealed(title_of_newest(version));
}

std::uint64_t base_of_newest(const std::string& name, std::string_view bytes) {
  return newest_reader(name, bytes).get<std::uint64_t>();
}

std::string newest_of(const std::string& path) {
  const std::filesystem::path file(path);
  return (file.parent_path() / file.stem()).string() + ".new";
}

GroundHead ground_head(const std::string& name, std::string_view bytes) {
  GroundMap ground{gpr::TraceMemoryOptions()};
  ground.version = version_of(name, bytes);
  ByteReader in(name, bytes, title(ground.version));
  get_format(in, ground);
  if (ground.version > 1) get_descent(in, ground);
  return {in.checksum(), ground.format, in.get<std::uint8_t>() != 0, ground.descent};
}

bool descends(const GroundHead& ground, const GroundHead& file) {
  const auto has = [&](const Ancestor& one) {
    return std::any_of(ground.descent.begin(), ground.descent.end(), [&](const Ancestor& own) {
      return own.mark == one.mark && own.until >= one.until;
    });
  };
  return !file.has_ground || file.identity == ground.identity || has({file.identity, 0}) ||
         (!file.descent.empty() && std::all_of(file.descent.begin(), file.descent.end(), has));
}

namespace {

// newest: what was added to the file since, if any, and its version.
GroundMap made(ByteReader in, int version, std::optional<std::pair<ByteReader, int>> newest,
               const gpr::TraceMemoryOptions& options) {
  GroundMap ground(options);
  ground.version = version;
  const ByteReader& last = newest ? newest->first : in;
  try {
    if (version == 1) {
      get_ground_1(in, ground);
    } else {
      Pieces pieces = get_pieces(in, ground);
      if (newest) get_newest(newest->first, newest->second, ground, pieces);
      restore(last, std::move(pieces), ground);
    }
  } catch (const std::invalid_argument& error) {
    last.refuse(error.what());
  }
  ground.identity = newest ? 0 : in.checksum();
  return ground;
}

}  // namespace

GroundMap ground_map_from(const std::string& name, std::string_view bytes,
                          const gpr::TraceMemoryOptions& options) {
  const int version = version_of(name, bytes);
  return made(ByteReader(name, bytes, title(version)), version, std::nullopt, options);
}

std::optional<GroundMap> read_ground_map(const std::string& path,
                                         const gpr::TraceMemoryOptions& options,
                                         std::vector<std::string>& notices) {
  std::string bytes, newest;
  if (!read_whole(path, bytes)) return std::nullopt;
  const int version = version_of(path, bytes);
  const ByteReader whole(path, bytes, title(version));
  const std::string beside = newest_of(path);
  try {
    if (version > 1 && read_whole(beside, newest) &&
        base_of_newest(beside, newest) == whole.checksum())
      return made(whole, version,
                  std::pair(newest_reader(beside, newest), version_of_newest(newest)), options);
  } catch (const FileError& error) {
    notices.emplace_back(error.what());
  }
  return made(whole, version, std::nullopt, options);
}

}  // namespace gprodom
